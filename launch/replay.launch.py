# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
Play a bag and observe its friction anew; the estimates that the bag may hold are not played.

::

    ros2 launch sosml_friction replay.launch.py bag:=RECORDED rate:=5.0
"""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue


def generate_launch_description():
    def value(argument, kind=str):
        # A text stays one when it looks like a number.
        return ParameterValue(LaunchConfiguration(argument), value_type=kind)

    def node(executable, **parameters):
        return Node(
            package='sosml_friction',
            executable=executable,
            parameters=[parameters],
            output='screen',
        )

    return LaunchDescription(
        [
            DeclareLaunchArgument('bag', description='Bag to play: a folder or one .mcap file.'),
            DeclareLaunchArgument('rate', default_value='1.0', description='2.0: twice as fast.'),
            DeclareLaunchArgument(
                'model', default_value='', description='Model folder; empty: the exoskeleton.'
            ),
            node(
                'observer_node',
                use_sim_time=True,
                model=value('model'),
                configuration=value('bag'),
            ),
            node(
                'replay_node',
                bag=value('bag'),
                rate=value('rate', float),
                exclude=['*/friction_estimate*', '*/observer_configuration'],
            ),
        ]
    )
