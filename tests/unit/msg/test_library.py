"""Libraries: what definitions mean in them, their revisions and full texts, and what a stranger's text may ask."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from rosproto.errors import DefinitionError
from rosproto.msg import (
    DefinitionLibrary,
    DefinitionLimits,
    bundled,
    join_full_text,
    library_from_full_text,
    parse_action,
    parse_message,
    parse_service,
    split_full_text,
)
from tests.support.msg_package import package

ROOT = Path(__file__).resolve().parents[3]
LINE = "=" * 80


def library(**texts: str) -> DefinitionLibrary:
    found = DefinitionLibrary()
    for name, text in texts.items():
        found.add(parse_message(text, f"p/{name}"))
    return found


class TestBundled:
    """What ships with this package."""

    def test_the_usual_packages_are_there(self) -> None:
        assert {"std_msgs", "geometry_msgs", "sensor_msgs", "nav_msgs", "tf2_msgs", "woosh_msgs"} <= set(
            bundled().packages()
        )

    def test_names_in_a_package_are_sorted_and_full(self) -> None:
        names = bundled().messages("woosh_msgs")
        assert names == sorted(set(names))
        assert {"woosh_msgs/Battery", "woosh_msgs/MoveBaseAction", "woosh_msgs/MoveBaseActionGoal"} <= set(
            names
        )
        assert "woosh_msgs/ExecTask" in bundled().services("woosh_msgs")
        assert "woosh_msgs/StepControl" in bundled().actions("woosh_msgs")
        assert bundled().messages("nobody_msgs") == []

    def test_header_needs_no_package(self) -> None:
        assert bundled().message("Header").name == "std_msgs/Header"
        assert bundled().md5sum("Header") == bundled().md5sum("std_msgs/Header")
        assert bundled().full_text("Header") == bundled().full_text("std_msgs/Header")

    def test_requests_and_responses_are_messages_too(self) -> None:
        assert bundled().message("std_srvs/SetBoolRequest").fields[0].name == "data"
        assert bundled().message("std_srvs/SetBoolResponse").fields[0].name == "success"

    def test_an_action_is_found_under_both_names(self) -> None:
        assert bundled().action("woosh_msgs/MoveBase") == bundled().action("woosh_msgs/MoveBaseAction")

    def test_the_vendor_s_second_spellings_are_the_same_definition(self) -> None:
        for other, name in (("wooshRosbagRecord", "WooshRosbagRecord"),):
            assert bundled().message(f"woosh_msgs/{other}").name == f"woosh_msgs/{other}"
            assert bundled().md5sum(f"woosh_msgs/{other}") == bundled().md5sum(f"woosh_msgs/{name}")
        assert bundled().service("woosh_msgs/wooshInit").request.name == "woosh_msgs/wooshInitRequest"
        assert {"woosh_msgs/wooshInit", "woosh_msgs/WooshInit"} <= set(bundled().services("woosh_msgs"))

    def test_upper_and_lower_case_differ_on_every_file_system(self) -> None:
        with pytest.raises(DefinitionError):
            bundled().message("std_msgs/string")

    def test_it_is_shared_and_so_not_added_to(self) -> None:
        with pytest.raises(DefinitionError, match="fork"):
            bundled().add(parse_message("", "a/B"))

    def test_every_text_is_ascii_and_ends_with_a_line_feed(self) -> None:
        """Peers with a narrow locale read them too. Some of std_msgs end without one in ROS: bags hold the text."""
        for path in sorted((ROOT / "msgdefs").rglob("*")):
            if path.suffix in {".msg", ".srv", ".action", ".txt"}:
                data = path.read_bytes()
                assert data.isascii(), path
                assert b"\r" not in data, path
                bare = path.parent == ROOT / "msgdefs" / "std_msgs" / "msg" and b"\n" not in data
                assert data.endswith(b"\n") or bare, path


class TestMissing:
    """An error about a missing type helps to find it."""

    def test_near_matches_are_named(self) -> None:
        with pytest.raises(DefinitionError, match="did you mean geometry_msgs/Twist"):
            bundled().message("geometry_msgs/Twits")
        with pytest.raises(DefinitionError, match="did you mean geometry_msgs"):
            bundled().message("geometry_msg/Twist")

    def test_it_says_where_it_looked(self, tmp_path: Path) -> None:
        package(tmp_path / "my_msgs", msg_Foo="int8 a")
        with pytest.raises(DefinitionError, match="looked in") as caught:
            bundled().fork([tmp_path]).message("my_msgs/Bar")
        assert str(tmp_path) in str(caught.value)
        assert "msgdefs" in str(caught.value)
        with pytest.raises(DefinitionError, match="library is empty"):
            DefinitionLibrary().message("a/B")

    @pytest.mark.parametrize(
        "name", ["", "Twist", "a/b/c", "../../etc/passwd", "std_msgs/../std_msgs/Int8", "a/" * 999]
    )
    def test_names_that_are_none_are_missing(self, name: str) -> None:
        """A name from the wire never becomes a path."""
        for ask in (bundled().message, bundled().service, bundled().action, bundled().md5sum):
            with pytest.raises(DefinitionError) as caught:
                ask(name)
            assert len(str(caught.value)) < 600

    def test_a_missing_type_of_a_field_names_the_field(self) -> None:
        found = library(A="B b", B="q/C[] c")
        for ask in (found.md5sum, found.full_text, found.dependencies):
            with pytest.raises(DefinitionError, match=r"p/B\.c: .*q/C"):
                ask("p/A")


class TestMeaning:
    """md5sums, texts and dependencies belong to the library that is asked."""

    def test_dependencies_are_depth_first_and_each_once(self) -> None:
        found = library(A="B b\nC c\nB again", B="D d", C="D d\nE e", D="", E="D[] d")
        assert found.dependencies("p/A") == ["p/B", "p/D", "p/C", "p/E"]

    @pytest.mark.promise("`message_definition` is the full text with all dependencies")
    def test_full_text_has_the_form_of_genpy(self) -> None:
        found = library(A="B b\n", B="# b\nint8 x")
        assert found.full_text("p/A") == f"B b\n\n{LINE}\nMSG: p/B\n# b\nint8 x"
        assert found.full_text("p/B") == "# b\nint8 x"

    @pytest.mark.parametrize("texts", [{"A": "A a"}, {"A": "B[] b", "B": "C c", "C": "A[2] a"}])
    def test_a_type_that_contains_itself_is_refused(self, texts: dict[str, str]) -> None:
        found = library(**texts)
        for ask in (found.md5sum, found.full_text, found.dependencies):
            with pytest.raises(DefinitionError, match="contains itself: p/A"):
                ask("p/A")

    def test_a_name_that_is_both_message_and_service(self) -> None:
        found = library(A="int8 a")
        found.add(parse_service("---\nint8 b", "p/A"))
        assert found.md5sum("p/A") == found.md5sum("p/A", kind="msg") != found.md5sum("p/A", kind="srv")
        assert found.full_text("p/A", kind="srv") == "---\nint8 b"

    def test_a_service_has_dependencies_of_both_parts(self) -> None:
        assert bundled().dependencies("nav_msgs/GetPlan")[:2] == [
            "geometry_msgs/PoseStamped",
            "std_msgs/Header",
        ]
        assert bundled().dependencies("nav_msgs/GetPlan")[-1] == "nav_msgs/Path"

    def test_a_fork_may_redefine_and_the_base_does_not_notice(self) -> None:
        before = bundled().md5sum("nav_msgs/Odometry")
        fork = bundled().fork()
        assert fork.md5sum("nav_msgs/Odometry") == before
        fork.add(parse_message("string frame_id", "std_msgs/Header"))
        assert fork.md5sum("nav_msgs/Odometry") != before
        assert bundled().md5sum("nav_msgs/Odometry") == before

    def test_actions_and_services_can_be_added(self) -> None:
        fork = bundled().fork()
        fork.add(parse_action("int8 a\n---\n---\n", "my/Do"))
        fork.add(parse_service("---\n", "my/Ask"))
        assert fork.dependencies("my/DoActionGoal") == [
            "std_msgs/Header",
            "actionlib_msgs/GoalID",
            "my/DoGoal",
        ]
        assert fork.messages("my") == sorted(
            "my/Do" + s
            for s in ("Action", "Goal", "Result", "Feedback", "ActionGoal", "ActionResult", "ActionFeedback")
        )
        assert fork.md5sum("my/Ask") == "d41d8cd98f00b204e9800998ecf8427e"
        assert fork.message("my/AskRequest").fields == ()


class TestRevisions:
    """Other known definitions of a type."""

    def test_the_page_s_exec_task_is_one(self) -> None:
        (revision,) = bundled().revisions("woosh_msgs/ExecTask")
        assert revision.label == "page"
        assert "task_exec" in revision.note
        names = [f.name for f in revision.library.service("woosh_msgs/ExecTask").request.fields]
        assert names[0] == "task_exec"

    def test_what_uses_a_revised_type_has_a_revision_too(self) -> None:
        """A goal of 1.1.0 is written the same but holds other steps; Information holds a Parameter."""
        assert [r.label for r in bundled().revisions("woosh_msgs/Information")] == ["page"]
        assert [r.label for r in bundled().revisions("woosh_msgs/StepControlActionGoal")] == [
            "1.1.0",
            "1.0.12",
        ]
        assert "pulsePerCircle" in bundled().revisions("woosh_msgs/Information")[0].note

    def test_revisions_are_cumulative(self) -> None:
        """The library of 1.0.7 also has the arm of 1.0.10: what came later is not in it."""
        revision = next(r for r in bundled().revisions("woosh_msgs/NavigationModeGoal") if r.label == "1.0.7")
        assert [f.name for f in revision.library.message("woosh_msgs/ArmGoal").fields] == [
            "task_type",
            "excute_type",
        ]

    def test_most_types_have_none(self) -> None:
        assert bundled().revisions("std_msgs/Bool") == []
        assert bundled().revisions("woosh_msgs/RobotStatus") == []

    def test_a_fork_knows_those_of_its_base(self) -> None:
        assert [r.md5sum for r in bundled().fork().revisions("woosh_msgs/Battery")] == [
            r.md5sum for r in bundled().revisions("woosh_msgs/Battery")
        ]

    def test_a_folder_may_bring_its_own(self, tmp_path: Path) -> None:
        folder = package(tmp_path / "m", msg_Foo="int8 a\nint8 b")
        package(folder / "revisions" / "old", msg_Foo="int8 a")
        (folder / "revisions" / "revisions.txt").write_text("# words\nold <\n  Foo: no b\n")
        (revision,) = DefinitionLibrary([folder]).revisions("m/Foo")
        assert (revision.label, revision.note) == ("old", "m/Foo: no b")

    @pytest.mark.parametrize("table", ["old\n", "  Foo: x\n", "old < newer\n", "old <\n  Foo\n"])
    def test_a_broken_table_is_an_error_with_its_line(self, tmp_path: Path, table: str) -> None:
        folder = package(tmp_path / "m", msg_Foo="int8 a")
        (folder / "revisions").mkdir()
        (folder / "revisions" / "revisions.txt").write_text(table)
        with pytest.raises(DefinitionError, match="label") as caught:
            DefinitionLibrary([folder]).revisions("m/Foo")
        assert caught.value.line == table.count("\n")


class TestFullText:
    """Texts of strangers: complete, legal and bounded, or refused."""

    def test_every_bundled_full_text_gives_the_same_md5sum_and_text(self) -> None:
        for name in [n for p in ("woosh_msgs", "visualization_msgs") for n in bundled().messages(p)]:
            text = bundled().full_text(name)
            learned = library_from_full_text(name, text)
            assert learned.md5sum(name) == bundled().md5sum(name)
            assert learned.full_text(name) == text

    def test_split_and_join(self) -> None:
        parts = {"p/A": "B b\n", "p/B": "int8 a", "p/C": ""}
        text = join_full_text("B b\n", [("p/B", "int8 a"), ("p/C", "")])
        assert split_full_text(text, "p/A") == parts

    def test_line_ends_of_windows_are_read(self) -> None:
        text = f"B b\r\n{LINE}\r\nMSG: p/B\r\nint8 a\r\n"
        assert library_from_full_text("p/A", text).dependencies("p/A") == ["p/B"]

    def test_a_missing_type_is_an_error_unless_the_base_has_it(self) -> None:
        with pytest.raises(DefinitionError, match=r"geometry_msgs/Twist"):
            library_from_full_text("p/A", "geometry_msgs/Twist t")
        learned = library_from_full_text("p/A", "geometry_msgs/Twist t", base=bundled())
        assert "geometry_msgs/Vector3" in learned.dependencies("p/A")

    def test_what_the_text_says_goes_before_the_base(self) -> None:
        text = f"std_msgs/Bool b\n{LINE}\nMSG: std_msgs/Bool\nint8 other"
        assert (
            library_from_full_text("p/A", text, base=bundled()).message("std_msgs/Bool").fields[0].name
            == "other"
        )

    def test_the_header_of_old_bags(self) -> None:
        """Before REP 100 it was in roslib, and `Header` meant that."""
        text = f"Header header\n{LINE}\nMSG: roslib/Header\n{bundled().full_text('Header')}"
        learned = library_from_full_text("p/A", text)
        assert learned.md5sum("std_msgs/Header") == bundled().md5sum("std_msgs/Header")

    @pytest.mark.parametrize(
        "text",
        [
            f"int8 a\n{LINE}\nMSG: Bad Name\nint8 a",
            f"int8 a\n{LINE}\nMSG: p\nint8 a",
            f"int8 a\n{LINE}\nMSG:\nint8 a",
            f"int8 a\n{LINE}\nMSG: p/B\nint8 a\n{LINE}\nMSG: p/B\nint8 b",
            f"int8 a\n{LINE}\nMSG: p/A\nint8 b",
            f"int8 a\n{LINE}\nMSG: p/x;import os\nint8 a",
            f"int8 a\n{LINE}\nint8 a",
            "int8 a;import os",
            "A a",
            f"B b\n{LINE}\nMSG: p/B\nA[] a",
            "int8 a\n" + "\0",
        ],
    )
    def test_wrong_texts_are_refused(self, text: str) -> None:
        with pytest.raises(DefinitionError):
            library_from_full_text("p/A", text)

    def test_the_same_type_twice_and_alike_is_fine(self) -> None:
        part = f"\n{LINE}\nMSG: p/B\nint8 a"
        assert library_from_full_text("p/A", "B b" + part + part).messages("p") == ["p/A", "p/B"]


def chain(length: int, field: str) -> str:
    """p/T0 uses p/T1 uses ... with `field` as the pattern of each use."""
    parts = [(f"p/T{n}", field.format(f"T{n + 1}")) for n in range(1, length)]
    return join_full_text(field.format("T1"), [*parts, (f"p/T{length}", "int8 a")])


class TestLimits:
    """Each bound of DefinitionLimits refuses by name, before anything large is made."""

    @pytest.mark.parametrize(
        ("limit", "text"),
        [
            ("text_bytes", "#" * ((1 << 20) + 1)),
            ("types", join_full_text("", [(f"p/B{n}", "") for n in range(1000)])),
            ("fields", "\n".join(f"int8 f{n}" for n in range(4097))),
            ("fields", "\n".join(f"int8 F{n}=1" for n in range(4097))),
            ("name_length", f"int8 {'a' * 256}"),
            ("name_length", f"int8 {'A' * 256}=1"),
            ("nesting", chain(65, "{} x")),
            ("nesting", chain(900, "{}[] x")),
            ("array_length", f"float64[{1 << 26}1] a"),
            ("array_length", "int8[99999999999999999999] a"),
            ("default_bytes", "float64[33554432] a"),
            ("default_objects", "string[65536] a"),
            ("default_objects", "time[65536] a"),
            ("default_objects", chain(1, "{}[65536] x")),
            ("default_objects", chain(10, "{}[100] x")),
            ("default_objects", join_full_text("E[67108864] e", [("p/E", "")])),
            ("flattened_fields", chain(12, "{0}[] x\n{0}[] y\n{0}[] z")),
        ],
    )
    def test_a_bomb_is_refused(self, limit: str, text: str) -> None:
        with pytest.raises(
            DefinitionError, match=f"DefinitionLimits.{limit}" if limit != "text_bytes" else limit
        ):
            library_from_full_text("p/T0", text)

    def test_a_flood_of_lines_is_refused_unread(self, monkeypatch: pytest.MonkeyPatch) -> None:
        text = "\n".join(f"int32 f{n}" for n in range(50_000))
        monkeypatch.setattr(
            "rosproto.msg.full_text_library.parse_message", lambda *_, **__: pytest.fail("it was read")
        )
        with pytest.raises(DefinitionError, match=r"p/T0: fields is 50000, .* DefinitionLimits.fields"):
            library_from_full_text("p/T0", text)

    def test_comments_and_empty_lines_are_no_fields(self) -> None:
        text = "\n".join(["int8 a", *["  # why", ""] * 10_000, "int8 b"])
        assert len(library_from_full_text("p/T0", text).message("p/T0").fields) == 2

    def test_a_limit_can_be_raised(self) -> None:
        text = chain(65, "{} x")
        learned = library_from_full_text("p/T0", text, limits=DefinitionLimits(nesting=65))
        assert len(learned.dependencies("p/T0")) == 65

    def test_definitions_as_large_as_real_ones_pass(self) -> None:
        library_from_full_text("p/T0", chain(64, "{}[] x"))
        library_from_full_text("p/T0", "uint8[2764800] image\nfloat64[1000000] values\nstring[5000] names")
        library_from_full_text("p/T0", "\n".join(f"float64 f{n}" for n in range(4000)))

    def test_a_long_name_of_the_message_itself(self) -> None:
        with pytest.raises(DefinitionError, match="name_length") as caught:
            library_from_full_text("p/" + "T" * 1000, "int8 a")
        assert len(str(caught.value)) < 300


def test_reading_definitions_loads_no_heavy_modules() -> None:
    """Start-up counts: a definition is read and hashed without what takes milliseconds to import."""
    program = (
        "import sys; import rosproto.msg; rosproto.msg.bundled().full_text('sensor_msgs/LaserScan');"
        "rosproto.msg.bundled().md5sum('sensor_msgs/LaserScan');"
        "heavy = {'inspect', 'dataclasses', 'importlib.resources', 'importlib.metadata', 'numpy',"
        "'pkgutil', 'difflib', 'ast'};"
        "heavy -= {'ast'} if sys.version_info >= (3, 14) else set();"  # its NamedTuple needs it
        "print(sorted(heavy & set(sys.modules)))"
    )
    done = subprocess.run(
        [sys.executable, "-I", "-c", f"import sys; sys.path.insert(0, {str(ROOT)!r}); {program}"],
        capture_output=True,
        text=True,
        timeout=60,
        check=True,
    )
    assert done.stdout.strip() == "[]"


def test_libraries_of_a_package_by_revision() -> None:
    """One library for each label, shared by all types, so that their classes are the same."""
    found = bundled().package_revisions("woosh_msgs")
    assert {"1.1.1", "1.1.0", "1.0.8", "page"} < set(found)
    assert found["1.1.0"].md5sum("woosh_msgs/StepControl") == "fee4a23e3d0493815f2ed5d9ce38a040"
    for name in ("woosh_msgs/StepControl", "woosh_msgs/StepControlActionGoal"):
        assert next(r for r in bundled().revisions(name) if r.label == "1.1.0").library is found["1.1.0"]
    assert bundled().fork().package_revisions("woosh_msgs") == found
    assert bundled().package_revisions("std_msgs") == {}
