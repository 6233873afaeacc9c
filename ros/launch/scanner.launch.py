"""Starts the scanner's node; by default configures and activates it."""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, EmitEvent, OpaqueFunction, RegisterEventHandler
from launch.conditions import IfCondition
from launch.events import matches_action
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import LifecycleNode, Node
from launch_ros.event_handlers import OnStateTransition
from launch_ros.events.lifecycle import ChangeState
from launch_ros.parameter_descriptions import ParameterValue
from launch_ros.substitutions import FindPackageShare
from lifecycle_msgs.msg import Transition

SHARE = FindPackageShare("slipstream_ros")
ARGUMENTS = {
    "params_file": (PathJoinSubstitution([SHARE, "config", "scanner.yaml"]), "the parameters"),
    "source": ("", "instead of the one in params_file, e.g. replay:scan.slip"),
    "scanner": ("", "instead of the one in params_file"),
    "frame_id": ("camera", "frame of the clouds, instead of the one in params_file"),
    "parent_frame": ("world", "the camera looks along its x axis; empty: no transform"),
    "autostart": ("true", "false: a lifecycle manager changes the node's state"),
    "rviz": ("false", "true: opens RViz"),
}
OPTICAL = "--qx -0.5 --qy 0.5 --qz -0.5 --qw 0.5".split()  # of z forward to x forward


def actions(context):
    given = {name: LaunchConfiguration(name).perform(context) for name in ARGUMENTS}
    frame, parent = given["frame_id"], given["parent_frame"]
    # Without value_type, "aravis:" would be read as YAML.
    overrides = {name: ParameterValue(LaunchConfiguration(name), value_type=str)
                 for name in ("source", "scanner", "frame_id") if given[name]}
    node = LifecycleNode(package="slipstream_ros", executable="scanner", name="scanner",
                         namespace="", output="screen",
                         parameters=[given["params_file"], overrides])
    transform = Node(package="tf2_ros", executable="static_transform_publisher", arguments=[
        "--frame-id", parent, "--child-frame-id", frame, *OPTICAL])
    rviz = Node(package="rviz2", executable="rviz2", condition=IfCondition(given["rviz"]),
                arguments=["-d", PathJoinSubstitution([SHARE, "rviz", "scanner.rviz"]),
                           "-f", parent or frame])

    def change(transition):
        return EmitEvent(condition=IfCondition(given["autostart"]), event=ChangeState(
            lifecycle_node_matcher=matches_action(node), transition_id=transition))

    configured = OnStateTransition(
        target_lifecycle_node=node, start_state="configuring", goal_state="inactive",
        entities=[change(Transition.TRANSITION_ACTIVATE)])
    return [RegisterEventHandler(configured), node, change(Transition.TRANSITION_CONFIGURE),
            *([transform] if parent else []), rviz]


def generate_launch_description():
    return LaunchDescription([
        *(DeclareLaunchArgument(name, default_value=default, description=description)
          for name, (default, description) in ARGUMENTS.items()),
        OpaqueFunction(function=actions)])
