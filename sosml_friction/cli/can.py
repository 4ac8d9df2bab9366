# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The commands ``sosml can``: look at the actuators on a bus without commanding any."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from sosml_friction.cli.options import JsonOrTableOption
from sosml_friction.exceptions import ConfigurationError

# As in cli.py, modules that load NumPy or python-can are imported where they are needed.

app = typer.Typer(
    name='can',
    no_args_is_help=False,
    help='Look at the actuators on a CAN bus. No motor is commanded.',
)

_NODE = 'driver_node'

ConfigOption = Annotated[
    Path | None,
    typer.Option(
        metavar='FILE.yaml',
        help='Parameter file with the section driver_node; it gives interface, channel and bit '
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
BitrateOption = Annotated[
    int | None, typer.Option(help='Bit rate [bit/s]; default: 1000000.', metavar='BIT/S')
]


@app.callback(invoke_without_command=True)
def _can(context: typer.Context) -> None:
    if context.invoked_subcommand is None:
        typer.echo(context.get_help())
        raise typer.Exit(2)


@app.command()
def scan(
    config: ConfigOption = None,
    interface: InterfaceOption = None,
    channel: ChannelOption = None,
    bitrate: BitrateOption = None,
    dbc: Annotated[
        Path | None,
        typer.Option(
            metavar='FILE.dbc',
            help='DBC of a servo bridge to ask as well; default: that of the package if a joint '
            'of the config file is a servo_dbc. A bridge answers only commands: it is sent "off".',
        ),
    ] = None,
    ids: Annotated[str, typer.Option(metavar='FIRST-LAST', help='Motor ids to ask.')] = '1-32',
    wait: Annotated[
        float, typer.Option(metavar='SECONDS', help='How long to wait for an answer.')
    ] = 0.15,
    json: JsonOrTableOption = False,
) -> None:
    """
    List who answers on the bus: id, kind, model, version, voltage, temperature, errors.

    Asks every RMD-X id and, with a DBC, the servo bridge. Where another host is talking, nothing
    is asked.

    Exit code 1 if nobody answers.

    Example: sosml can scan --interface slcan --channel socket://127.0.0.1:29536
    """
    from sosml_friction.actuators.bus.can_scan import scan_bus
    from sosml_friction.actuators.bus.clock import MonotonicClock
    from sosml_friction.actuators.bus.inquiry import Inquiry
    from sosml_friction.actuators.bus.open_bus import open_bus
    from sosml_friction.report.common.output import to_json
    from sosml_friction.report.common.progress import progress
    from sosml_friction.report.common.tables import print_table
    from sosml_friction.report.plan.can_view import scan_document, scan_table

    values = _parameters(config)
    bus_of = _bus_of(values, interface, channel, bitrate)
    motors = _motor_ids(ids)
    if not 0.001 <= wait <= 60.0:
        raise ConfigurationError(f'the wait is {wait:g} s: give 0.001 to 60')
    bridge = str(dbc or _bridge(values) or '')
    with progress('listening and asking'):
        bus = open_bus(*bus_of)
        try:
            found = scan_bus(Inquiry(bus, MonotonicClock(), motors, bridge, wait))
        finally:
            _close(bus)
    if json:
        typer.echo(to_json(scan_document(found, *bus_of)))
    elif found:
        print_table(scan_table(found))
    if not found:
        typer.echo(
            f'sosml: nobody answers on {bus_of[0]} {bus_of[1]}: check power, wiring, termination '
            f'and the bit rate {bus_of[2]}',
            err=True,
        )
        raise typer.Exit(1)


@app.command()
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
    from sosml_friction.report.common.output import to_json
    from sosml_friction.report.common.progress import progress
    from sosml_friction.report.common.tables import print_table
    from sosml_friction.report.plan.can_view import check_document, check_table
    from sosml_friction.share import share_directory

    values = _parameters(config or share_directory() / 'config' / 'exoskeleton.yaml')
    bus_of = _bus_of(values, interface, channel, bitrate)
    with progress('asking the actuators'):
        result = check_bus(values, *bus_of)
    document = check_document(result, *bus_of)
    if json:
        typer.echo(to_json(document))
    else:
        print_table(check_table(result))
        typer.echo(document['verdict'])
    if any(own.problem for own in result):
        raise typer.Exit(1)


def _parameters(config: Path | None) -> dict[str, Any]:
    from sosml_friction.actuators.driver.configuration import read_parameters

    return {} if config is None else read_parameters(config, _NODE)


def _bridge(values: dict[str, Any]) -> Path | None:
    """Return the DBC of the first joint of the file that has one, None if none has."""
    from sosml_friction.actuators.actuator import Actuator
    from sosml_friction.actuators.parameter import parameters_of
    from sosml_friction.share import share_directory

    for joint in values.get('joints') or []:
        kind = Actuator.kind(values.get(f'{joint}.driver'), f'{joint}.driver')
        if 'dbc' in parameters_of(kind.configuration_type):
            own = values.get(f'{joint}.dbc')
            return Path(own) if own else share_directory() / 'config' / 'elbow_servo.dbc'
    return None


def _bus_of(
    values: dict[str, Any], interface: str | None, channel: str | None, bitrate: int | None
) -> tuple[str, str, int]:
    """
    Return interface, channel and bit rate: the options', else the file's.

    :raises ConfigurationError: if none of them says one.
    """
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
    return str(interface), str(channel), rate


def _motor_ids(text: str) -> range:
    first, _, last = text.partition('-')
    try:
        ids = range(int(first), int(last or first) + 1)
    except ValueError:
        ids = range(0)
    if not ids or ids[0] < 1 or ids[-1] > 32:
        raise ConfigurationError(f'the ids {text!r} are no range from 1 to 32, as 1-32 is')
    return ids


def _close(bus: Any) -> None:
    import contextlib

    import can

    # What was found stands, whether the adapter says goodbye or not.
    with contextlib.suppress(can.CanError, OSError):
        bus.shutdown()
