"""The files of the package for ROS agree with its node and each other.

The launch file runs with stand-ins for ROS's modules, which keep what they are given.
"""

import pathlib
import re
import sys
import types
import xml.etree.ElementTree

import pytest

yaml = pytest.importorskip("yaml")

SOURCES = pathlib.Path(__file__).parents[2]
ROS = SOURCES / "ros"
LAUNCH = ROS / "launch" / "scanner.launch.py"
NODE = (ROS / "src" / "scanner_node.cpp").read_text()
FRAME = re.search(r'camera_frame = "(.*)"',
                  (SOURCES / "include" / "slipstream" / "cloud.h").read_text())[1]
RVIZ = yaml.safe_load((ROS / "rviz" / "scanner.rviz").read_text())["Visualization Manager"]


class Kept:
    """An action, event or substitution: its class's name and its arguments."""

    def __init__(self, *positional, **named):
        self.positional = positional
        self.__dict__.update(named)


class LaunchConfiguration(Kept):
    def perform(self, context):
        return context[self.positional[0]]


STANDINS = {
    "launch": ["LaunchDescription"],
    "launch.actions": ["DeclareLaunchArgument", "EmitEvent", "OpaqueFunction",
                       "RegisterEventHandler"],
    "launch.conditions": ["IfCondition"],
    "launch.events": ["matches_action"],
    "launch.substitutions": ["PathJoinSubstitution"],
    "launch_ros": [],
    "launch_ros.actions": ["LifecycleNode", "Node"],
    "launch_ros.event_handlers": ["OnStateTransition"],
    "launch_ros.events": [],
    "launch_ros.events.lifecycle": ["ChangeState"],
    "launch_ros.parameter_descriptions": ["ParameterValue"],
    "launch_ros.substitutions": ["FindPackageShare"],
    "lifecycle_msgs": [],
    "lifecycle_msgs.msg": [],
}


@pytest.fixture
def launched(monkeypatch):
    """launched(rviz="true"): the arguments and the actions that start."""
    for name, members in STANDINS.items():
        module = types.ModuleType(name)
        for member in members:
            setattr(module, member, type(member, (Kept,), {}))
        monkeypatch.setitem(sys.modules, name, module)
    sys.modules["launch.substitutions"].LaunchConfiguration = LaunchConfiguration
    sys.modules["lifecycle_msgs.msg"].Transition = types.SimpleNamespace(
        TRANSITION_CONFIGURE=1, TRANSITION_ACTIVATE=3)
    content = {"__name__": "scanner_launch"}
    exec(compile(LAUNCH.read_text(), LAUNCH, "exec"), content)

    def launch(**given):
        *declared, opaque = content["generate_launch_description"]().positional[0]
        arguments = {one.positional[0]: one.default_value for one in declared} | given
        actions = opaque.function(arguments)
        assert set(given) <= {one.positional[0] for one in declared}
        return arguments, [one for one in actions if starts(one)]
    return launch


def starts(action):
    condition = getattr(action, "condition", None)
    return condition is None or condition.positional[0] == "true"


def kinds(actions):
    return [getattr(one, "package", type(one).__name__) for one in actions]


def path_of(joined):
    share, *parts = joined.positional[0]
    assert share.positional == ("slipstream_ros",)
    return ROS.joinpath(*parts)


def test_parameters_file_has_the_node_s_parameters():
    declared = re.findall(r'declare_parameter<(.*?)>\("(\w+)", (.*)\);', NODE)
    assert len(declared) == NODE.count("declare_parameter")
    read = {"std::string(camera_frame)": FRAME}
    file = yaml.safe_load((ROS / "config" / "scanner.yaml").read_text())
    given = file["/**"]["ros__parameters"]
    assert given == {name: read.get(value, yaml.safe_load(value)) for _, name, value in declared}
    types_of = {"std::string": str, "double": float, "bool": bool}
    assert all(type(given[name]) is types_of[declared_type] for declared_type, name, _ in declared)
    lines = (ROS / "config" / "scanner.yaml").read_text().splitlines()[3:]
    assert len(lines) == len(given) and all("  # " in line for line in lines)


def test_launch_configures_and_activates_the_node(launched):
    arguments, actions = launched()
    assert kinds(actions) == ["RegisterEventHandler", "slipstream_ros", "EmitEvent", "tf2_ros"]
    handler, node, configure, _ = actions
    assert type(node).__name__ == "LifecycleNode"
    registered = re.search(r"EXECUTABLE (\w+)\)", (ROS / "CMakeLists.txt").read_text())[1]
    assert node.executable == registered
    assert path_of(arguments["params_file"]).is_file()
    assert node.parameters[0] is arguments["params_file"]
    assert list(node.parameters[1]) == ["frame_id"] and arguments["frame_id"] == FRAME
    configured = handler.positional[0]
    assert (configured.start_state, configured.goal_state) == ("configuring", "inactive")
    (activate,) = configured.entities
    assert starts(activate) and configured.target_lifecycle_node is node
    assert [one.event.transition_id for one in (configure, activate)] == [1, 3]
    assert configure.event.lifecycle_node_matcher.positional == (node,)


def test_launch_arguments_change_what_starts(launched):
    _, actions = launched(autostart="false", rviz="true", parent_frame="", source="aravis:",
                          scanner="rig.yaml", frame_id="optical")
    assert kinds(actions) == ["RegisterEventHandler", "slipstream_ros", "rviz2"]
    assert not starts(actions[0].positional[0].entities[0])
    overrides = actions[1].parameters[1]
    assert list(overrides) == ["source", "scanner", "frame_id"]
    for name, value in overrides.items():
        assert value.value_type is str and value.positional[0].positional == (name,)
    assert actions[2].arguments[2:] == ["-f", "optical"]


def test_transform_turns_the_optical_axis_forward(launched):
    _, actions = launched(frame_id="optical", parent_frame="cell")
    words = actions[-1].arguments
    named = dict(zip(words[::2], words[1::2]))
    assert (named.pop("--frame-id"), named.pop("--child-frame-id")) == ("cell", "optical")
    x, y, z, w = (float(named.pop(name)) for name in ("--qx", "--qy", "--qz", "--qw"))
    assert not named
    forward = (2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y))
    down = (2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x))
    assert forward == (1, 0, 0) and down == (0, 0, -1)


def test_rviz_shows_the_node_s_points(launched):
    arguments, actions = launched(rviz="true")
    option, file = actions[-1].arguments[:2]
    assert option == "-d" and path_of(file).is_file()
    (points,) = RVIZ["Displays"]
    assert points["Class"] == "rviz_default_plugins/PointCloud2"
    assert points["Topic"]["Value"] == f"/{actions[1].name}/points" and '"~/" + topic.name' in NODE
    assert points["Topic"]["Reliability Policy"] == "Best Effort" and "SensorDataQoS" in NODE
    assert RVIZ["Global Options"]["Fixed Frame"] == arguments["parent_frame"]


def test_package_names_what_it_uses(launched):
    package = xml.etree.ElementTree.parse(ROS / "package.xml").getroot()
    named = {tag: {one.text for one in package.findall(tag)}
             for tag in ("depend", "buildtool_depend", "exec_depend")}
    cmake = (ROS / "CMakeLists.txt").read_text()
    found = set(re.findall(r"find_package\((\w+)", cmake)) - {"slipstream"}
    assert found == named["depend"] | named["buildtool_depend"]
    imported = set(re.findall(r"^from (\w+)", LAUNCH.read_text(), re.M))
    _, actions = launched(rviz="true")
    started = {one.package for one in actions if hasattr(one, "package")} - {"slipstream_ros"}
    assert imported | started | {"sensor_msgs"} == named["exec_depend"]
    assert package.findtext("name") == re.search(r"project\((\w+)", cmake)[1] == "slipstream_ros"
