# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
Start the exoskeleton's driver and the friction observer, and on demand the identifier.

::

    ros2 launch sosml_friction exoskeleton.launch.py emulate:=true identify:=true

``emulate:=true`` also starts the emulated exoskeleton, at the bus that the default parameters
name: no hardware is needed. ``one_process:=true`` runs driver and observer in one process. Only
this machine finds the nodes, unless ``discovery:=SUBNET`` or ROS_AUTOMATIC_DISCOVERY_RANGE says
otherwise.
"""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.conditions import IfCondition, UnlessCondition
from launch.substitutions import (
    EnvironmentVariable,
    LaunchConfiguration,
    PathJoinSubstitution,
)
from launch_ros.actions import LifecycleNode, Node
from launch_ros.parameter_descriptions import ParameterFile, ParameterValue
from launch_ros.substitutions import FindPackageShare


def generate_launch_description():
    parameters = ParameterFile(LaunchConfiguration('params_file'), allow_substs=True)
    # Of the nodes alone: what includes this file keeps its own.
    discovery = {'ROS_AUTOMATIC_DISCOVERY_RANGE': LaunchConfiguration('discovery')}
    emulate = LaunchConfiguration('emulate')
    one_process = LaunchConfiguration('one_process')
    autostart = ParameterValue(LaunchConfiguration('autostart'), value_type=bool)

    def switch(name, default, description):
        return DeclareLaunchArgument(
            name, default_value=default, choices=['true', 'false'], description=description
        )

    def node(executable, **more):
        return Node(
            package='sosml_friction',
            executable=executable,
            parameters=[parameters],
            output='screen',
            additional_env=discovery,
            **more,
        )

    return LaunchDescription(
        [
            DeclareLaunchArgument(
                'params_file',
                default_value=PathJoinSubstitution(
                    [FindPackageShare('sosml_friction'), 'config', 'exoskeleton.yaml']
                ),
                description='Parameters of all nodes; the default ones are for the emulator.',
            ),
            switch('emulate', 'false', 'Start the emulated exoskeleton too.'),
            switch(
                'autostart',
                'true',
                'Configure and activate the driver; nothing moves before ~/enable.',
            ),
            switch('identify', 'false', 'Start the identifier too; it waits for ~/start.'),
            switch('one_process', 'false', 'Run driver and observer in one process.'),
            DeclareLaunchArgument(
                'discovery',
                default_value=EnvironmentVariable(
                    'ROS_AUTOMATIC_DISCOVERY_RANGE', default_value='LOCALHOST'
                ),
                description='Who finds these nodes: LOCALHOST, or SUBNET for other machines too.',
            ),
            node('emulator_node', condition=IfCondition(emulate)),
            # Jazzy's launch_ros cannot start lifecycle nodes itself: the driver has `autostart`.
            # An emulator, or an adapter, may not be listening yet when it first asks; the
            # parameter file may say otherwise.
            LifecycleNode(
                package='sosml_friction',
                executable='driver_node',
                name='driver_node',
                namespace='',
                parameters=[{'bus_wait': 10.0}, parameters, {'autostart': autostart}],
                output='screen',
                additional_env=discovery,
                condition=UnlessCondition(one_process),
            ),
            node('observer_node', condition=UnlessCondition(one_process)),
            node(
                'exoskeleton_node',
                # By the node's name: a parameter for all nodes would be the observer's, too.
                ros_arguments=[
                    '-p',
                    'driver_node:bus_wait:=10.0',
                    '-p',
                    ['driver_node:autostart:=', LaunchConfiguration('autostart')],
                ],
                condition=IfCondition(one_process),
            ),
            node('identifier_node', condition=IfCondition(LaunchConfiguration('identify'))),
        ]
    )
