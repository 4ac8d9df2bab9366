# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
Observe the friction of a robot that another driver runs: joint_states in, friction_estimate out.

::

    ros2 launch sosml_friction observe.launch.py model:=FOLDER namespace:=left_arm

Without ``urdf_path`` the robot is that of the topic robot_description, without ``reliability`` the
subscription follows the driver's. Only this machine finds the node, unless ``discovery:=SUBNET``
or ROS_AUTOMATIC_DISCOVERY_RANGE says otherwise.
"""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.substitutions import EnvironmentVariable, LaunchConfiguration
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue


def generate_launch_description():
    def value(argument, kind=str):
        # A text stays one when it looks like a number.
        return ParameterValue(LaunchConfiguration(argument), value_type=kind)

    return LaunchDescription(
        [
            DeclareLaunchArgument(
                'model', description='Model folder of the robot (sosml model new ROBOT.urdf).'
            ),
            DeclareLaunchArgument(
                'urdf_path', default_value='', description='URDF file; empty: robot_description.'
            ),
            DeclareLaunchArgument(
                'reliability',
                default_value='automatic',
                choices=['automatic', 'reliable', 'best_effort'],
                description='Of the subscription to joint_states.',
            ),
            DeclareLaunchArgument(
                'velocity_source',
                default_value='message',
                choices=['message', 'position_difference'],
                description='Velocity of joint_states, or difference of its positions.',
            ),
            DeclareLaunchArgument(
                'bandwidth', default_value='40.0', description='Of the observers [rad/s].'
            ),
            DeclareLaunchArgument(
                'limit_excess',
                default_value='2.0',
                description='An effort or velocity beyond so many times its limit in the URDF is '
                'no measurement.',
            ),
            DeclareLaunchArgument(
                'passive_joints',
                # Of an empty array the type is not known.
                default_value="['']",
                description="Joints without an actuator: '[wheel, caster]'.",
            ),
            DeclareLaunchArgument(
                'namespace', default_value='', description='Of the topics and the node.'
            ),
            DeclareLaunchArgument(
                'discovery',
                default_value=EnvironmentVariable(
                    'ROS_AUTOMATIC_DISCOVERY_RANGE', default_value='LOCALHOST'
                ),
                description='Who finds these nodes: LOCALHOST, or SUBNET for other machines too.',
            ),
            Node(
                package='sosml_friction',
                executable='observer_node',
                namespace=LaunchConfiguration('namespace'),
                parameters=[
                    {
                        'model': value('model'),
                        'urdf_path': value('urdf_path'),
                        'reliability': value('reliability'),
                        'velocity_source': value('velocity_source'),
                        'bandwidth': value('bandwidth', float),
                        'limit_excess': value('limit_excess', float),
                        # By the rules of YAML: launch knows no list[str].
                        'passive_joints': value('passive_joints', None),
                    }
                ],
                output='screen',
                # Of the node alone: what includes this file keeps its own.
                additional_env={'ROS_AUTOMATIC_DISCOVERY_RANGE': LaunchConfiguration('discovery')},
            ),
        ]
    )
