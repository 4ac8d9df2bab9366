# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The commands ``sosml can``: look at the actuators on a bus without commanding any."""

from contextlib import suppress
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import typer

from sosml_friction.cli.app import app, print_result, progress, remark, show_help
from sosml_friction.cli.options import JsonOrTableOption, option
from sosml_friction.exceptions import ConfigurationError
from sosml_friction.share import share_directory

_NODE = 'driver_node'

ConfigOption = Annotated[
    Path | None,
    option(
        'FILE.yaml',
        'Parameter file with the section driver_node; it gives interface, channel and bit '
        'rate where the options do not.',
    ),
]
InterfaceOption = Annotated[
    str | None,
    typer.Option(help='python-can interface: socketcan, slcan, udp_multicast, pcan, ...'),
]
ChannelOption = Annotated[
    str | None, typer.Option(help='Its channel: can0, /dev/ttyACM0, socket://127.0.0.1:29536, ...')
]
BitrateOption = Annotated[int | None, option('BIT/S', 'Bit rate [bit/s]; default: 1000000.')]

can_app = typer.Typer(
    name='can', help='Look at the actuators on a CAN bus. No motor is commanded.'
)
can_app.callback(invoke_without_command=True)(show_help)
app.add_typer(can_app)


class _BusName(NamedTuple):
    """Say which bus: interface and channel as python-can names them, bit rate [bit/s]."""

    interface: str
    channel: str
    bitrate: int


@can_app.command()
def scan(
    config: ConfigOption = None,
    interface: InterfaceOption = None,
    channel: ChannelOption = None,
    bitrate: BitrateOption = None,
    dbc: Annotated[
        Path | None,
        option(
            'FILE.dbc',
            'DBC of a servo bridge to ask as well; default: that of the package if a joint '
            'of the config file is a servo_dbc. A bridge answers only commands: it is sent "off".',
        ),
    ] = None,
    ids: Annotated[str, option('FIRST-LAST', 'Motor ids to ask.')] = '1-32',
    wait: Annotated[float, option('SECONDS', 'How long to wait for an answer.')] = 0.15,
    json: JsonOrTableOption = False,
) -> None:
    """
    List who answers on the bus: id, kind, model, version, voltage, temperature, errors.

    Asks every RMD-X id and, with a DBC, the servo bridge. Where another host is talking, nothing
    is asked.

    Exit code 1 if nobody answers.

    Example: sosml can scan --interface slcan --channel socket://127.0.0.1:29536
    """
    import can

    from sosml_friction.actuators.bus.can_check import scan_bus
    from sosml_friction.actuators.bus.clock import Clock
    from sosml_friction.actuators.bus.inquiry import Inquiry
    from sosml_friction.actuators.bus.open_bus import open_bus
    from sosml_friction.report.plan.can_view import scan_document, scan_table

    values = _parameters(config)
    name = _bus_name(values, interface, channel, bitrate)
    motors = _motor_ids(ids)
    if not 0.001 <= wait <= 60.0:
        raise ConfigurationError(f'the wait is {wait:g} s: give 0.001 to 60')
    bridge = str(dbc or _bridge(values) or '')
    with progress('listening and asking'):
        bus = open_bus(*name)
        try:
            found = scan_bus(Inquiry(bus, Clock(), motors, bridge, wait))
        finally:
            # What was found stands, whether the adapter says goodbye or not.
            with suppress(can.CanError, OSError):
                bus.shutdown()
    print_result(json, scan_document(found, *name), [scan_table(found)] if found else [])
    if not found:
        remark(
            f'nobody answers on {name.interface} {name.channel}: check power, wiring, termination '
            f'and the bit rate {name.bitrate}'
        )
        raise typer.Exit(1)


@can_app.command()
def check(
    config: ConfigOption = None,
    interface: InterfaceOption = None,
    channel: ChannelOption = None,
    bitrate: BitrateOption = None,
    json: JsonOrTableOption = False,
) -> None:
    """
    Go through the driver's start-up without writing anything, and say what it finds.

    Version, model, status, position, the motor's own watchdog, for every joint of the config
    file, and the load of the bus; each with a verdict. Takes some seconds.

    Exit code 1 if the driver would refuse to enable a joint.

    Example: sosml can check --config config/exoskeleton.yaml
    """
    from sosml_friction.actuators.bus.can_check import check_bus
    from sosml_friction.report.plan.can_view import check_document, check_table

    values = _parameters(config or share_directory() / 'config' / 'exoskeleton.yaml')
    name = _bus_name(values, interface, channel, bitrate)
    with progress('asking the actuators'):
        result = check_bus(values, *name)
    document = check_document(result, *name)
    print_result(json, document, [check_table(result), document['verdict']])
    if not document['ready']:
        raise typer.Exit(1)


def _parameters(config: Path | None) -> dict[str, Any]:
    from sosml_friction.actuators.driver.configuration import read_parameters

    return {} if config is None else read_parameters(config, _NODE)


def _bridge(values: dict[str, Any]) -> Path | None:
    """Return the DBC of the first joint of the file that has one, None if none has."""
    from sosml_friction.actuators.actuator import Actuator
    from sosml_friction.actuators.parameter import parameters_of

    for joint in values.get('joints') or []:
        kind = Actuator.kind(values.get(f'{joint}.driver'), f'{joint}.driver')
        if 'dbc' in parameters_of(kind.configuration_type):
            own = values.get(f'{joint}.dbc')
            return Path(own) if own else share_directory() / 'config' / 'elbow_servo.dbc'
    return None


def _bus_name(
    values: dict[str, Any], interface: str | None, channel: str | None, bitrate: int | None
) -> _BusName:
    """Return which bus the options name, else the file."""
    interface = interface or values.get('can_interface')
    channel = channel or values.get('can_channel')
    if not interface or not channel:
        raise ConfigurationError(
            'which bus is not said: give --interface and --channel, or a parameter file with '
            '--config'
        )
    rate = bitrate if bitrate is not None else values.get('can_bitrate', 1_000_000)
    if isinstance(rate, bool) or not isinstance(rate, int) or not 10_000 <= rate <= 1_000_000:
        raise ConfigurationError(f'the bit rate is {rate}: give 10000 to 1000000 bit/s')
    return _BusName(str(interface), str(channel), rate)


def _motor_ids(text: str) -> range:
    first, _, last = text.partition('-')
    try:
        ids = range(int(first), int(last or first) + 1)
    except ValueError:
        ids = range(0)
    if not ids or ids[0] < 1 or ids[-1] > 32:
        raise ConfigurationError(f'the ids {text!r} are no range from 1 to 32, as 1-32 is')
    return ids
