"""Each line of the table in docs/safety.md is held by a test, in both languages; this names it."""

from __future__ import annotations

import ast
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
FUNCTIONS = ast.FunctionDef | ast.AsyncFunctionDef
HELD_BY = {
    "the velocity block is left, or an exception leaves it": (
        "test_motion.py::test_a_velocity_block_moves_and_ends_in_zero",
        "test_motion.py::test_an_exception_in_the_block_ends_in_zero",
    ),
    "a velocity is not repeated within": ("test_motion.py::test_a_command_that_is_not_refreshed_lapses",),
    "`chassis.stop()`, from any thread": (
        "test_motion.py::test_stop_ends_a_drive_and_it_cannot_be_revived",
        "test_safety.py::test_a_stop_also_stops_the_goal_that_another_thread_is_just_about_to_send",
    ),
    "`chassis.stop(everything=True)`, `woosh stop`": (
        "test_stop.py::test_goals_and_tasks_of_others_are_cancelled",
        "test_misuse.py::test_stopping_everything_names_another_program_that_drives_by_velocity",
    ),
    "`chassis.stop(end_drivers=True)`": (
        "test_stop.py::test_programs_that_drive_are_asked_to_end_and_zero_follows",
    ),
    "`handle.wait(timeout=...)` runs out": (
        "test_motion.py::test_a_navigation_timeout_cancels_and_confirms_the_stop",
        "test_numbers_of_numpy.py::test_a_wait_for_a_goal_ends_in_time_and_cancels",
    ),
    "Ctrl-C in a program that uses `with`": (
        "test_ends_of_programs.py::test_ctrl_c_ends_every_wait_and_stops_the_robot",
    ),
    "an asyncio task is cancelled": (
        "test_aio.py::test_a_time_limit_cancels_the_goal",
        "test_aio.py::test_a_sibling_that_fails_cancels_the_goal",
        "test_aio.py::test_cancelling_a_hold_stops_the_robot_within_the_block",
        "test_aio.py::test_ctrl_c_in_asyncio_run_leaves_the_robot_standing",
        "test_aio_storm.py::test_the_robot_stands_after_every_cancel",
    ),
    "Ctrl-C in `handle.wait()`": (
        "test_stop.py::test_ctrl_c_in_a_wait_cancels_the_goal_although_no_block_is_left",
        "test_numbers_of_numpy.py::test_whatever_ends_a_wait_cancels_its_goal",
    ),
    "Ctrl-C again and again": (
        "test_holders.py::test_a_storm_of_interrupts_abandons_nothing",
        "test_safety.py::test_a_second_ctrl_c_while_the_blocks_are_left_stops_the_robot_all_the_same",
    ),
    "Ctrl-C or SIGTERM in a `woosh` command": (
        "test_cli_terminal.py::test_ctrl_c_and_signals_stop_the_robot_and_restore_the_terminal",
    ),
    "SIGQUIT (Ctrl-\\\\) or SIGHUP to a `woosh` command": (
        "test_unread_output.py::test_a_signal_ends_a_drive_on_a_terminal_that_takes_nothing",
        "test_cli_terminal.py::test_ctrl_c_and_signals_stop_the_robot_and_restore_the_terminal",
    ),
    "nobody reads what a `woosh` command prints": (
        "test_unread_output.py::test_a_signal_stops_every_motion_although_nobody_reads",
        "test_unread_output.py::test_a_signal_stops_the_robot_whichever_output_is_full",
        "test_unread_output.py::test_a_time_limit_fires_whichever_output_is_full",
    ),
    "the `Chassis` block is left, or the program ends in an orderly way": (
        "test_misuse.py::test_whatever_leaves_the_block_stops_the_robot",
        "test_motion.py::test_an_orderly_exit_without_with_stops_the_robot_too",
        "test_holders.py::test_nothing_begins_while_a_chassis_is_being_closed",
    ),
    "`rosnode kill` of our node": (
        "test_holders.py::test_zero_is_sent_before_the_driving_node_is_shut_down",
        "test_holders.py::test_goals_are_cancelled_before_their_node_is_shut_down",
        "test_holders.py::test_goals_are_cancelled_when_another_node_takes_our_name",
    ),
    "the network is away when a motion is asked to end": (
        "scenarios/network/test_stop_and_link.py::test_a_goal_that_was_asked_to_end_in_silence",
        "scenarios/network/test_stop_and_link.py::test_a_drive_that_was_ended_in_silence",
    ),
    "`stop()` or `close()` in a signal handler": (
        "test_stop_in_handler.py::test_stop_over_any_line_of_a_drive",
        "test_stop_in_handler.py::test_stop_over_any_line_of_a_goal",
        "test_stop_in_handler.py::test_close_over_any_line",
        "test_stop_in_handler.py::test_a_real_signal_at_a_random_moment_of_a_loop_that_drives",
    ),
    "the system gives no more threads or files": ("test_stop_without_means.py::test_the_robot_stands",),
    "a second motion while one of ours is under way": (
        "test_second_motion.py::test_a_second_motion_is_refused_and_the_first_goes_on",
        "test_second_motion.py::test_one_that_is_meant_replaces_it",
    ),
    "emergency stop, key switch to manual": (
        "test_motion.py::test_an_emergency_stop_ends_a_drive_and_releasing_it_resumes_nothing",
        "test_motion.py::test_turning_the_key_to_manual_ends_a_drive",
    ),
    "the link is lost in a velocity block": (
        "test_motion.py::test_a_lost_subscriber_ends_the_drive_at_once_and_zero_comes_first_afterwards",
    ),
    "another program can send velocities, too": (
        "test_sharing.py::test_the_second_of_two_programs_is_refused_until_the_first_has_left_its_block",
        "test_sharing.py::test_a_program_that_sends_beside_a_drive_ends_it",
    ),
    "the robot stands for 3 s": (
        "test_safety.py::test_a_robot_that_stands_although_it_is_told_to_move_ends_the_drive",
    ),
    "the program was stopped for more than a second": (
        "test_safety.py::test_a_drive_does_not_go_on_after_its_program_was_stopped",
    ),
    "kill -9 (or a crash, or no memory left) of `woosh web`": (
        "test_watchdog.py::test_after_kill_9_the_robot_stands_and_nobody_is_left",
        "test_watchdog.py::test_goals_that_are_left_running_are_left_by_the_watchdog_too",
    ),
    "kill -9 of `rosproto bridge`": (
        "test_watchdog.py::test_after_kill_9_the_robot_stands_and_nobody_is_left",
    ),
    "one of these is stopped": (
        "test_watchdog.py::test_a_program_that_is_stopped_or_hangs_is_taken_for_gone",
    ),
    "the watchdog itself is killed": (
        "test_watchdog.py::test_a_killed_watchdog_is_replaced_and_the_next_one_does_the_same",
    ),
    "**the program and its watchdog are killed at once": (
        "test_motion.py::test_what_remains_of_a_killed_process_is_the_chassis_own_behaviour",
        "test_watchdog.py::test_without_a_watchdog_it_drives_on",
    ),
    "a hand that drives from the page": (
        "test_web_dead_man.py::test_zero_follows_within_half_a_second",
        "test_web_dead_man.py::test_a_page_whose_process_is_stopped_or_killed",
        "test_web_dead_man.py::test_after_a_cut_nothing_resumes_when_the_network_is_back",
        "test_web_dead_man.py::test_beats_that_a_slow_network_delivers_late_do_not_drive",
        "web/test_page_pad.py::test_what_is_shown_during_a_drive_moves_no_pad",
        "web/test_page_pad.py::test_a_pad_that_moves_ends_the_drive",
    ),
    "SIGTERM to `woosh web`": ("test_web_dead_man.py::test_a_server_that_is_ended_by_sigterm",),
    "STOP in the page": (
        "test_web_live.py::test_a_stop_of_anybody_ends_the_drive_and_nothing_resumes",
        "test_web_dead_man.py::test_a_stop_that_another_person_gives_ends_the_drive_in_zero",
        "test_web_api.py::test_stop_answers_what_stands_still",
        "test_web_stop.py::test_a_stop_stops_first_and_complains_afterwards",
        "web/test_page_stop.py::test_a_session_that_is_not_known_holds_no_stop_up",
        "web/test_page_stop.py::test_the_red_button_is_named_within_a_second",
        "test_web_stop.py::test_a_body_that_never_ends_holds_no_stop_up",
        "test_web_stop.py::test_a_stop_begins_although_all_threads_of_requests_and_stops_wait",
        "test_web_stop.py::test_a_stop_over_the_connection_waits_for_nothing_that_was_asked_before",
        "test_web_api.py::test_without_the_token_nothing_but_the_page_is_shown",
        "test_web_api.py::test_a_foreign_page_may_change_nothing",
    ),
    "SIGTERM to a program of yours": (
        "test_ends_of_programs.py::test_a_goal_of_a_killed_program_goes_on_and_another_program_can_stop_it",
        "test_ends_of_programs.py::test_a_program_that_turns_sigterm_into_an_exit_stops_the_robot",
    ),
}
"""How a line begins, and the tests that hold it, in tests/scenarios or where their path says."""


def lines(page: str, header: str) -> list[str]:
    """First cells of the safety table."""
    table = (ROOT / page).read_text("utf-8").partition(header)[2].partition("\n\n")[0]
    return [row.split(" | ")[0].removeprefix("| ") for row in table.splitlines()[2:]]


def test_every_line_has_its_tests_and_every_test_its_line() -> None:
    found = lines("docs/safety.md", "| what happens | what stops, and how |")
    assert len(found) == len(HELD_BY)
    for line, begin in zip(found, HELD_BY, strict=True):
        assert line.startswith(begin)


def test_the_chinese_table_has_as_many_lines() -> None:
    assert len(lines("docs/safety.zh-CN.md", "| 发生了什么 | 什么会停，怎样停 |")) == len(HELD_BY)


@pytest.mark.parametrize("name", sorted({name for names in HELD_BY.values() for name in names}))
def test_the_test_is_there(name: str) -> None:
    file, _, function = name.partition("::")
    folder = ROOT / "tests" if "/" in file else ROOT / "tests" / "scenarios"
    tree = ast.parse((folder / file).read_text("utf-8"))
    assert function in {node.name for node in tree.body if isinstance(node, FUNCTIONS)}


def test_security_md_points_here() -> None:
    assert re.search(rf"`tests/{Path(__file__).name}`", (ROOT / "SECURITY.md").read_text("utf-8"))
