# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
Play a bag and observe its friction anew; the estimates that the bag may hold are not played.

::

    ros2 launch sosml_friction replay.launch.py bag:=RECORDED rate:=5.0

A bag of another recorder has no gains, and perhaps no robot_description; it gets them so::

    ros2 launch sosml_friction replay.launch.py bag:=FOREIGN configuration:= model:=FOLDER
        urdf_path:=FOLDER/robot.urdf bandwidth:=40.0

It ends with the bag. Only this machine finds the nodes, unless ``discovery:=SUBNET`` or
ROS_AUTOMATIC_DISCOVERY_RANGE says otherwise.
"""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, Shutdown
from launch.substitutions import EnvironmentVariable, LaunchConfiguration
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue


def generate_launch_description():
    def value(argument, kind=str):
        # A text stays one when it looks like a number.
        return ParameterValue(LaunchConfiguration(argument), value_type=kind)

    def node(executable, parameters, **more):
        return Node(
            package='sosml_friction',
            executable=executable,
            parameters=[parameters],
            output='screen',
            # Of the nodes alone: what includes this file keeps its own.
            additional_env={'ROS_AUTOMATIC_DISCOVERY_RANGE': LaunchConfiguration('discovery')},
            **more,
        )

    return LaunchDescription(
        [
            DeclareLaunchArgument('bag', description='Bag to play: a folder or one .mcap file.'),
            DeclareLaunchArgument('rate', default_value='1.0', description='2.0: twice as fast.'),
            DeclareLaunchArgument(
                'model', default_value='', description='Model folder; empty: the exoskeleton.'
            ),
            DeclareLaunchArgument(
                'urdf_path',
                default_value='',
                description='URDF file; empty: robot_description of the bag.',
            ),
            DeclareLaunchArgument(
                'configuration',
                default_value=LaunchConfiguration('bag'),
                description='Bag or file whose gains run; empty: those of the bandwidth.',
            ),
            DeclareLaunchArgument(
                'bandwidth',
                default_value='40.0',
                description='Bandwidth [rad/s] of the gains where no configuration has them.',
            ),
            DeclareLaunchArgument(
                'discovery',
                default_value=EnvironmentVariable(
                    'ROS_AUTOMATIC_DISCOVERY_RANGE', default_value='LOCALHOST'
                ),
                description='Who finds these nodes: LOCALHOST, or SUBNET for other machines too.',
            ),
            node(
                'observer_node',
                {
                    'use_sim_time': True,
                    'model': value('model'),
                    'urdf_path': value('urdf_path'),
                    'configuration': value('configuration'),
                    'bandwidth': value('bandwidth', float),
                },
            ),
            # It ends when every message was acknowledged; the observer alone would go on.
            node(
                'replay_node',
                {
                    'bag': value('bag'),
                    'rate': value('rate', float),
                    'exclude': ['*/friction_estimate*', '*/observer_configuration'],
                },
                on_exit=Shutdown(reason='replay_node has ended'),
            ),
        ]
    )
