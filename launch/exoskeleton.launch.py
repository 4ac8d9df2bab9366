# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
Start the exoskeleton's driver and the friction observer, and on demand the identifier.

::

    ros2 launch sosml_friction exoskeleton.launch.py emulate:=true identify:=true

``emulate:=true`` also starts the emulated exoskeleton, at the bus that the default parameters
name: no hardware is needed.
"""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.conditions import IfCondition
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import LifecycleNode, Node
from launch_ros.parameter_descriptions import ParameterFile, ParameterValue
from launch_ros.substitutions import FindPackageShare


def generate_launch_description():
    parameters = ParameterFile(LaunchConfiguration('params_file'), allow_substs=True)
    emulate = LaunchConfiguration('emulate')
    return LaunchDescription(
        [
            DeclareLaunchArgument(
                'params_file',
                default_value=PathJoinSubstitution(
                    [FindPackageShare('sosml_friction'), 'config', 'exoskeleton.yaml']
                ),
                description='Parameters of all nodes; the default ones are for the emulator.',
            ),
            DeclareLaunchArgument(
                'emulate',
                default_value='false',
                choices=['true', 'false'],
                description='Start the emulated exoskeleton too.',
            ),
            DeclareLaunchArgument(
                'autostart',
                default_value='true',
                choices=['true', 'false'],
                description='Configure and activate the driver; nothing moves before ~/enable.',
            ),
            DeclareLaunchArgument(
                'identify',
                default_value='false',
                choices=['true', 'false'],
                description='Start the identifier too; it waits for ~/start.',
            ),
            Node(
                package='sosml_friction',
                executable='emulator_node',
                parameters=[parameters],
                output='screen',
                condition=IfCondition(emulate),
            ),
            # Jazzy's launch_ros cannot start lifecycle nodes itself: the driver has `autostart`.
            # Respawned, it finds an emulator that was not yet listening when it first asked.
            LifecycleNode(
                package='sosml_friction',
                executable='driver_node',
                name='driver_node',
                namespace='',
                parameters=[
                    parameters,
                    {
                        'autostart': ParameterValue(
                            LaunchConfiguration('autostart'), value_type=bool
                        )
                    },
                ],
                output='screen',
                respawn=emulate,
                respawn_delay=1.0,
                respawn_max_retries=10,
            ),
            Node(
                package='sosml_friction',
                executable='observer_node',
                parameters=[parameters],
                output='screen',
            ),
            Node(
                package='sosml_friction',
                executable='identifier_node',
                parameters=[parameters],
                output='screen',
                condition=IfCondition(LaunchConfiguration('identify')),
            ),
        ]
    )
