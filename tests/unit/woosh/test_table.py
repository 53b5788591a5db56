"""The interface table, the status codes, the values: pure parts."""

from __future__ import annotations

import math
import subprocess
import sys

import pytest

from woosh_pure import interface
from woosh_pure.enums import RobotState, TaskState
from woosh_pure.faults import ActiveFaults, FaultLevel, all_codes, decode_status_code
from woosh_pure.geometry import Footprint, Pose2D, normalize_angle, quaternion_from_yaw, yaw_from_quaternion
from woosh_pure.gridmap import GridMap
from woosh_pure.sim.site import built_in_site


def test_the_page_has_18_topics_to_read_6_to_write_7_services_and_3_actions():
    page = [r for r in interface.ROWS if r.source == "page"]
    counts = {flow: sum(r.flow == flow for r in page) for flow in ("read", "write", "call", "act")}
    assert counts == {"read": 18, "write": 6, "call": 7, "act": 3}


def test_names_and_feeds_are_unique():
    names = [r.name for r in interface.ROWS]
    assert len(set(names)) == len(names)
    feeds = [r.feed for r in interface.ROWS if r.feed]
    assert len(set(feeds)) == len(feeds)


def test_several_nodes_publish_where_several_were_seen():
    assert len(interface.row("/status_code").providers) == 6
    assert len(interface.row("/tf").providers) == 8
    assert len(interface.row("/scan").providers) == 2
    assert len(interface.row("/move_base/global_plan").providers) == 5


def test_a_row_is_found_by_alias_and_a_typing_mistake_is_answered_with_near_names():
    assert interface.row("kShelfLedColorPubName").name == "/rgbled_shelf"
    with pytest.raises(KeyError, match="/battery"):
        interface.row("/batery")


def test_every_velocity_topic_says_that_it_bypasses_protection():
    for r in interface.ROWS:
        assert r.bypasses_protection == (r.flow == "write" and r.type == "geometry_msgs/Twist")


def test_every_code_of_the_table_has_both_sentences_and_a_level():
    codes = list(all_codes())
    assert len(codes) == 816
    assert all(c.english and c.chinese and c.identifier for c in codes)
    assert sum(not c.derived for c in codes) == 57


def test_a_code_is_taken_apart_into_its_digits():
    code = decode_status_code(130103000012)
    assert (code.version, code.department, code.module, code.submodule) == (1, 3, 1, 3)
    assert (code.function_state, code.level) == (1, FaultLevel.WARNING)
    assert "lost" in code.english
    assert decode_status_code(131011000012).other_identifiers == ("SYS_FEED_FAILED",)


@pytest.mark.parametrize("code", [0, 1, 7, 2**64 - 1, 999999999999, 130103000019])
def test_any_number_gives_a_value(code):
    decoded = decode_status_code(code)
    assert not decoded.known
    assert str(code) in decoded.english


def test_a_recovered_submodule_clears_its_own_faults_only():
    faults = ActiveFaults()
    faults.receive(110201000013)
    faults.receive(110201000023)
    faults.receive(130103000012)
    assert [f.code for f in faults.active] == [110201000013, 110201000023, 130103000012]
    faults.receive(110201000000)
    assert [f.code for f in faults.active] == [130103000012]


def test_submodule_00_clears_its_whole_module_and_notices_are_no_faults():
    faults = ActiveFaults()
    faults.receive(140201000022)
    faults.receive(130104000011)
    assert len(faults.active) == 1
    faults.receive(140200000000)
    assert faults.active == ()


def test_unknown_numbers_become_named_members_and_still_compare():
    assert TaskState(42) == 42
    assert not TaskState(42).known
    assert str(RobotState.IN_TASK) == "in task"


@pytest.mark.parametrize("yaw", [0.0, 1.0, -3.0, math.pi])
def test_yaw_survives_the_quaternion(yaw):
    assert yaw_from_quaternion(*quaternion_from_yaw(yaw)) == pytest.approx(yaw)


def test_angles_are_normalised_and_nan_is_refused():
    assert normalize_angle(3 * math.pi) == pytest.approx(math.pi)
    assert normalize_angle(-math.pi) == math.pi
    with pytest.raises(ValueError, match="finite"):
        normalize_angle(math.nan)


def test_poses_of_two_frames_are_not_compared():
    with pytest.raises(ValueError, match="odom"):
        Pose2D(0, 0).distance_to(Pose2D(1, 0, 0, "odom"))


def test_the_vendors_footprint_with_padding():
    corners = [(-0.4, 0.253), (-0.353, 0.3), (0.353, 0.3), (0.4, 0.253), (0.4, -0.253), (0.353, -0.3), (-0.353, -0.3), (-0.4, -0.253)]  # fmt: skip
    footprint = Footprint.from_points(corners, padding=0.1)
    assert footprint.points[0] == pytest.approx((-0.5, 0.353))
    assert footprint.inscribed_radius == pytest.approx(0.4)


@pytest.mark.parametrize(
    ("points", "what"),
    [
        ([(0, 0), (1, 1)], "3 corners"),
        ([(-1, -1), (1, 1), (1, -1), (-1, 1)], "cross"),
        ([(1, 1), (2, 1), (2, 2)], "contain"),
        ([(math.nan, 1), (2, 1), (2, 2)], "finite"),
        ([(1, 1), (1, 1), (-1, -1), (1, -1)], "same point"),
    ],
)
def test_a_bad_footprint_is_refused(points, what):
    with pytest.raises(ValueError, match=what):
        Footprint.from_points(points)


def test_a_map_survives_its_files(tmp_path):
    grid = built_in_site().grid
    yaml_path, image = grid.save(tmp_path / "hall")
    assert image.read_bytes().startswith(b"P5\n# 0.050 m/pix\n240 160\n255\n")
    again = GridMap.load(yaml_path)
    assert (again.cells == grid.cells).all()
    assert (again.resolution, again.origin) == (grid.resolution, grid.origin)
    assert grid.save_png(tmp_path / "hall.png").read_bytes().startswith(b"\x89PNG")


def test_a_broken_map_file_says_what_is_wrong(tmp_path):
    (tmp_path / "m.yaml").write_text("image: m.pgm\nresolution: 0.05\norigin: [0, 0, 0]\n")
    (tmp_path / "m.pgm").write_bytes(b"P5\n10 10\n255\nshort")
    with pytest.raises(ValueError, match="cut short"):
        GridMap.load(tmp_path / "m.yaml")


def test_importing_the_package_loads_neither_numpy_nor_the_network():
    code = (
        "import sys, woosh_pure; print([m for m in ('numpy', 'socket', 'rosproto.node') if m in sys.modules])"
    )
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=True)
    assert out.stdout.strip() == "[]"


def test_the_chassis_loads_numpy_with_its_first_array_only():
    code = "import sys, woosh_pure.chassis; print('numpy' in sys.modules)"
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=True)
    assert out.stdout.strip() == "False"
