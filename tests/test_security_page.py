"""SECURITY.md names every limit with its default, so that nobody has to read the source for it."""

from __future__ import annotations

import ast
import re
from pathlib import Path

from rosproto.bag import BagLimits
from rosproto.gateway import GatewayLimits
from rosproto.msg import DefinitionLimits
from rosproto.protocol.limits import Limits

PAGE = (Path(__file__).resolve().parent.parent / "SECURITY.md").read_text("utf-8")


HOLDS = {
    "what is refused is answered with a sentence": [
        "unit/gateway/foxglove/test_server.py::test_nothing_is_written_at_first",
        "unit/gateway/foxglove/test_server.py::test_read_only_wins_over_patterns",
        "unit/gateway/foxglove/test_server.py::test_what_is_opened_is_written",
    ],
    "on an address that others reach only with a token": [
        "unit/gateway/foxglove/test_server.py::test_others_than_this_computer_need_a_token",
        "unit/gateway/foxglove/test_server.py::test_strangers_stay_outside",
        "unit/gateway/foxglove/test_handshake.py::test_the_token",
    ],
    "unless its origin is open": [
        "unit/gateway/foxglove/test_handshake.py::test_pages_from_elsewhere",
        "unit/gateway/foxglove/test_handshake.py::test_another_name_for_this_computer_is_no_way_in",
    ],
    "Zero follows a viewer that drove and went or fell silent": [
        "unit/gateway/foxglove/test_server.py::test_zero_follows_a_client_that_drove",
        "unit/gateway/foxglove/test_server.py::test_closing_sends_zero_too",
    ],
    "A viewer that does not read costs its own 32 MiB": [
        "unit/gateway/foxglove/test_server.py::test_a_client_that_does_not_read_gets_the_newest_later",
        "unit/gateway/foxglove/test_server.py::test_a_client_that_reads_nothing_at_all_is_cut_off",
    ],
    "half a request ends after five": [
        "unit/gateway/foxglove/test_server.py::test_half_a_request_ends",
    ],
    "the number of viewers, of topics each follows": [
        "unit/gateway/foxglove/test_server.py::test_a_client_may_not_follow_everything",
        "unit/gateway/foxglove/test_server.py::test_strangers_stay_outside",
    ],
    "Files are given from named folders only": [
        "unit/gateway/foxglove/test_assets.py::test_what_is_no_file_of_a_robot",
        "unit/gateway/foxglove/test_assets.py::test_what_is_not_there_or_leads_out_or_is_too_large",
    ],
    "gets nothing done and ends the session": [
        "unit/gateway/foxglove/test_listening_port.py::test_where_the_port_stays_open_the_first_is_not_taken_for_the_viewer",
    ],
    "before anything is offered, and one who was there before": [
        "unit/gateway/foxglove/test_listening_port.py::test_the_port_is_closed_when_the_viewer_is_there",
        "unit/gateway/foxglove/test_listening_port.py::test_who_was_there_before_ends_it",
    ],
    "a page from a file says": [
        "unit/gateway/foxglove/test_server.py::test_strangers_stay_outside",
        "unit/cli/test_foxglove_command.py::test_the_page_on_the_internet_may_look_and_not_write",
    ],
    "no chunk gives more than it declares, and a length beyond the file takes no memory": [
        "unit/bag/test_bag_mcap.py::test_a_chunk_that_unpacks_to_more_than_it_says",
        "unit/bag/test_bag_mcap.py::test_lengths_beyond_the_file_cost_nothing",
    ],
    "does not fill a table": [
        "unit/bag/test_bag_arrow.py::test_elements_of_no_bytes_do_not_fill_the_memory",
    ],
    "A server that lies about ranges is an error": [
        "unit/bag/test_bag_remote.py::test_servers_that_lie",
    ],
    "elsewhere it takes a token of at least 8 letters": [
        "scenarios/test_web_api.py::test_off_this_computer_only_with_a_token",
        "scenarios/test_web_api.py::test_without_the_token_nothing_but_the_page_is_shown",
        "scenarios/test_web_live.py::test_without_the_token_the_page_is_told_why",
        "unit/woosh/web/test_access.py::test_a_token_that_can_be_guessed_or_not_be_sent_is_refused",
    ],
    "answered ten times, then once every six seconds": [
        "scenarios/test_web_api.py::test_who_guesses_tokens_is_slowed_down",
        "unit/woosh/web/test_access.py::test_who_guesses_is_slowed_down_and_nobody_else",
    ],
    "a cookie that scripts cannot read and other sites do not send": [
        "scenarios/test_web_api.py::test_the_page_logs_in_with_a_cookie_that_scripts_cannot_read",
    ],
    "is refused (DNS rebinding)": [
        "scenarios/test_web_api.py::test_a_name_that_is_not_ours_is_refused_for_everything",
        "unit/woosh/web/test_access.py::test_another_name_is_dns_rebinding",
    ],
    "page of another site asks for": [
        "scenarios/test_web_api.py::test_a_foreign_page_may_change_nothing",
        "scenarios/test_web_live.py::test_a_foreign_page_gets_no_connection",
        "unit/woosh/web/test_access.py::test_only_our_own_page_may_change_something",
    ],
    "(Content-Security-Policy without exceptions)": [
        "scenarios/test_web_api.py::test_the_page_has_a_strict_policy_and_nothing_is_framed",
    ],
    "nonsense ends that connection in a sentence": [
        "scenarios/test_web_live.py::test_nonsense_ends_that_connection_in_a_sentence",
        "scenarios/test_web_live.py::test_a_flood_ends_that_connection",
        "scenarios/test_web_api.py::test_a_body_that_is_too_large_is_not_read",
        "scenarios/test_web_api.py::test_hostile_bodies_get_a_sentence_and_move_nothing",
    ],
    "A stop is carried out before its body is read": [
        "scenarios/test_web_stop.py::test_a_body_of_100_megabytes_holds_no_stop_up",
        "scenarios/test_web_stop.py::test_a_flood_of_stops_takes_few_threads_and_the_last_one_counts",
    ],
    "until then it costs two frames": [
        "scenarios/test_web_live.py::test_a_page_that_acknowledges_nothing_gets_two_frames_and_a_sentence",
        "scenarios/test_web_live.py::test_a_page_that_stops_reading_costs_no_memory",
    ],
    "200 goals and 20 bags are kept": [
        "scenarios/test_web_live.py::test_more_pages_than_are_shown_are_told",
        "unit/woosh/web/test_values.py::test_sessions_have_a_bound_and_those_that_went_first_make_room",
        "unit/woosh/web/test_values.py::test_the_journal_keeps_its_last_entries_and_how_they_ended",
    ],
    "driving by velocity needs `--allow-driving`, the lease and": [
        "scenarios/test_web_live.py::test_driving_is_off_unless_it_was_allowed",
        "scenarios/test_web_live.py::test_driving_needs_the_lease_and_the_confirmation",
        "scenarios/test_web_api.py::test_odd_methods_get_a_sentence",
    ],
    "a definition of its own goes with its connection": [
        "unit/node/test_peer_costs.py::test_a_revision_goes_with_its_last_subscriber",
        "unit/node/test_peer_costs.py::test_one_that_leaves_during_the_handshake_leaves_nothing",
        "unit/node/test_peer_costs.py::test_many_subscribers_with_definitions_of_their_own_take_no_memory",
    ],
    "is bounded in number and length": [
        "unit/test_kept.py::test_the_entry_used_longest_ago_makes_room",
        "unit/node/test_peer_costs.py::test_what_peers_define_is_kept_by_its_length",
        "unit/node/test_peer_costs.py::test_what_was_looked_for_in_vain_is_kept_by_number",
        "unit/node/test_peer_costs.py::test_the_name_of_a_subscriber_is_cut",
        "unit/action/test_action_flood.py::test_servers_under_invented_names_are_forgotten",
        "unit/action/test_action_flood.py::test_goals_that_have_ended_are_told_of_within_bounds",
    ],
    "A transform buffer takes 10,000 frames, 50,000 poses of each, and names of 1000 characters": [
        "unit/tf/test_buffer.py::test_the_number_of_frames_and_samples_is_bounded",
        "unit/tf/test_buffer.py::test_names_of_frames_are_bounded_in_number_and_length",
        "unit/rospy/test_rospy_modules.py::test_frames_of_a_peer_are_bounded",
    ],
    "It sends only what it was told before the motion, and only when its program is gone": [
        "unit/watchdog/test_process.py::test_what_was_dropped_is_off_the_graph_and_gets_nothing",
        "unit/watchdog/test_watchdog.py::test_what_stands_is_not_sent_a_zero",
        "unit/watchdog/test_watchdog.py::test_an_orderly_end_takes_the_watchdog_along_and_sends_nothing",
        "unit/watchdog/test_watchdog.py::test_one_that_was_never_needed_ends_with_its_program",
    ],
    "gives what others send to one that is read alike, or leaves it out and says so": [
        "unit/recording/test_recorder.py::test_headers_of_publishers_are_bounded",
    ],
    "nothing it sends leaves the protocol as an exception": [
        "fuzz/test_fuzz.py::test_a_fixed_handful_of_mutations_finds_nothing",
        "property/test_rosbridge_values.py::test_any_message_is_done_or_refused",
        "property/test_rosbridge_values.py::test_any_values_fit_or_are_refused",
        "unit/gateway/rosbridge/test_protocol.py::test_wrong_messages",
        "unit/gateway/rosbridge/test_protocol.py::test_a_required_field_is_missed",
        "unit/gateway/rosbridge/test_values.py::test_wrong_values",
    ],
    "A message is bounded in bytes, in nesting, and in its values and keys": [
        "unit/gateway/rosbridge/test_protocol.py::test_size_is_bounded",
        "unit/gateway/rosbridge/test_protocol.py::test_nesting_is_bounded",
        "unit/gateway/rosbridge/test_protocol.py::test_values_are_bounded",
        "unit/gateway/test_json_text.py::test_values_are_counted_before_they_are_decoded",
        "unit/gateway/test_json_text.py::test_keys_count",
        "unit/gateway/foxglove/test_publishing.py::test_json_that_fits_nothing",
    ],
    "where nothing may be written it has 64 KiB, before authentication 4 KiB": [
        "unit/gateway/test_websocket_server.py::test_who_may_write_nothing_says_nothing_long",
    ],
    "of all clients' long messages one is decoded at a time": [
        "unit/gateway/test_json_text.py::test_one_long_text_is_decoded_at_a_time",
        "unit/gateway/test_rosbridge.py::test_long_calls_are_limited",
        "unit/gateway/rosbridge/test_protocol.py::test_what_takes_long_is_left_to_a_rest",
        "unit/gateway/rosbridge/test_protocol.py::test_fragments_of_a_long_message_are_left_to_a_rest",
    ],
    "zero within half a second, at most 300 MB": [
        "scenarios/hostile/test_long_messages.py::test_zero_is_in_time_while_clients_send_all_they_can",
    ],
    "before its connection was reset is not carried out any more": [
        "scenarios/hostile/test_long_messages.py::test_a_client_that_is_torn_off_leaves_no_velocities_to_play_out",
    ],
    "16 may be incomplete, all together as large as one message, for ten minutes": [
        "unit/gateway/rosbridge/test_fragments.py::test_what_is_incomplete_is_bounded",
    ],
    "is in no answer of `/rosapi`, by whatever spelling of its name": [
        "unit/gateway/rosbridge/rosapi/test_answers.py::test_what_is_denied_is_in_no_list",
        "unit/gateway/rosbridge/rosapi/test_parameters.py::test_a_hidden_parameter_is_not_read",
    ],
    "A namespace of parameters is no way around a pattern": [
        "unit/gateway/rosbridge/rosapi/test_parameters.py::test_a_namespace_is_no_way_around",
        "unit/gateway/rosbridge/rosapi/test_parameters.py::test_a_pattern_of_one_parameter_opens_that_one",
        "unit/gateway/rosbridge/rosapi/test_parameters.py::test_nothing_is_written_by_default",
    ],
    "a million characters at most, a parameter's value 32 levels, an answer 300 types": [
        "unit/gateway/rosbridge/rosapi/test_answers.py::test_what_cannot_be_answered_is_a_sentence",
        "unit/gateway/rosbridge/rosapi/test_answers.py::test_a_master_that_is_gone_is_a_sentence",
        "unit/gateway/rosbridge/rosapi/test_answers.py::test_a_provider_that_is_silent_holds_up_nobody_for_long",
        "unit/gateway/rosbridge/rosapi/test_parameters.py::test_deep_values_are_refused",
        "unit/gateway/rosbridge/rosapi/test_type_details.py::test_a_definition_without_end_gives_a_bounded_answer",
    ],
    "64 of each at a time, 500 frames, 100 Hz at most": [
        "unit/gateway/rosbridge/test_tf_republisher.py::test_a_goal_without_sense_is_rejected",
        "unit/gateway/rosbridge/test_tf_republisher.py::test_topics_of_the_service_are_bounded",
        "unit/gateway/rosbridge/test_tf_republisher.py::test_goals_are_bounded",
    ],
    "They end with their client, and are not there where `/tf` is hidden": [
        "unit/gateway/rosbridge/test_tf_on_demand.py::test_it_begins_with_the_first_goal_and_ends_with_its_client",
        "unit/gateway/rosbridge/test_tf_on_demand.py::test_where_tf_is_hidden_it_is_not_there",
        "unit/gateway/rosbridge/test_tf_on_demand.py::test_other_goals_stay_closed",
    ],
    "A picture is measured before it is unpacked": [
        "unit/gateway/rosbridge/test_png.py::test_what_is_no_such_picture",
        "unit/gateway/rosbridge/test_png.py::test_a_bomb_takes_no_memory",
        "unit/gateway/rosbridge/test_protocol.py::test_pictures_in_one_message_are_bounded",
    ],
    "a message comes in 4096 at most": [
        "unit/gateway/rosbridge/test_fragments.py::test_small_fragments_of_a_large_text_are_made_larger",
    ],
    "the rospy layer keeps latched messages of those publishers that are connected": [
        "unit/rospy/test_rospy_modules.py::test_latched_messages_of_publishers_that_have_gone_are_forgotten",
    ],
    "tried every few seconds": [
        "unit/node/test_peer_costs.py::test_a_publisher_that_agrees_and_leaves_is_not_told_of_every_time",
        "unit/node/incoming/test_link_state.py::test_sessions_that_end_at_once_are_no_success",
    ],
    "every few minutes": [
        "unit/node/test_peer_costs.py::test_a_publisher_of_another_type_is_asked_once",
        "unit/node/incoming/test_link_state.py::test_another_definition_is_not_asked_again_and_again",
    ],
    "Your own folders and the bundled definitions come before it": [
        "unit/node/revisions/test_own_first.py::test_the_order",
        "unit/cli/test_own_definitions.py::test_the_users_own_come_first_everywhere",
    ],
    "a type whose name no file can have is left out": [
        "scenarios/test_learn.py::test_a_type_no_file_can_be_named_after_is_left_out_and_told",
    ],
    "the rest is counted": [
        "unit/test_logs.py::test_a_flood_is_counted_instead_of_told",
        "unit/test_logs.py::test_a_flood_about_invented_things_is_bounded",
        "unit/test_logs.py::test_long_texts_are_cut",
    ],
    "gives a value or a documented error on *that one* connection": [
        "fuzz/test_fuzz.py::test_the_corpus_gives_values_or_documented_errors",
        "scenarios/hostile/test_floods.py::test_garbage",
        "scenarios/hostile/test_floods.py::test_resets_anywhere",
        "scenarios/hostile/test_handshakes.py::test_a_header_of_impossible_length_ends_the_connection",
        "scenarios/hostile/test_handshakes.py::test_request_length_bombs",
        "scenarios/hostile/test_odd_publishers.py::test_a_bad_publisher_costs_its_own_link_and_is_taken_back_when_it_is_good",
        "scenarios/hostile/test_slave_calls.py::test_a_flood_of_every_slave_call",
        "scenarios/hostile/test_xmlrpc.py::test_bodies_that_are_no_calls",
        "unit/master/test_master_server.py::test_hostile_requests_cost_their_own_connection_only",
    ],
    "every input that once broke one is kept as a test": [
        "fuzz/test_fuzz.py::test_every_corpus_belongs_to_a_target",
    ],
    "Nothing that is received is evaluated": [
        "test_security_page.py::test_code_is_made_and_run_in_these_places_only",
        "unit/codec/test_classes.py::test_a_field_name_that_is_no_identifier_never_reaches_the_generator",
    ],
    "XML with a DOCTYPE or entities is refused": [
        "unit/protocol/test_xmlrpc_codec.py::test_doctype_and_entities_are_refused",
        "scenarios/hostile/test_xmlrpc.py::test_entities_are_refused",
    ],
    "A node listens on the one address": [
        "unit/node/test_node_lifecycle.py::test_it_listens_on_one_address_only",
        "unit/transport/test_tcp_server.py::test_it_listens_on_the_given_address_only",
    ],
    "`allow=` takes a list of addresses": [
        "unit/transport/test_tcp_server.py::test_a_peer_that_is_not_allowed_is_closed_at_once",
        "unit/transport/test_tcp_server.py::test_a_failing_allow_function_lets_nobody_in",
        "unit/transport/test_xmlrpc_server.py::test_peers_that_are_not_allowed_get_nothing",
        "unit/master/test_master_server.py::test_only_allowed_addresses_may_connect",
    ],
    "with `allow=` only to the addresses in it": [
        "unit/node/incoming/test_datagram_links.py::test_a_request_that_makes_no_sense_or_may_not_be_made",
        "unit/node/incoming/test_datagram_links.py::test_datagrams_of_strangers_change_nothing",
    ],
    "A name that cannot be resolved is taken for the master's host": [
        "unit/transport/test_host_names.py::test_an_unknown_name_is_taken_for_the_masters_host_and_told_once",
    ],
    "never a request to end": [
        "unit/cli/test_commands.py::test_kill_never_ends_a_node_that_is_only_guessed",
    ],
    "A subscriber takes datagrams only after `unreliable=True`": [
        "unit/node/incoming/test_datagram_links.py::test_who_does_not_ask_for_datagrams_gets_none",
    ],
    "zero comes from a new node once more": [
        "scenarios/test_holders.py::test_zero_is_sent_before_the_driving_node_is_shut_down",
    ],
    "64 such names are remembered and warned of": [
        "unit/transport/test_host_names.py::test_what_peers_announce_is_bounded",
    ],
    "are checked with the master instead of believed": [
        "unit/node/graph/test_node_slave.py::test_publisher_updates_count_from_the_master_only",
        "unit/node/graph/test_node_slave.py::test_a_forged_publisher_update_is_put_right_by_the_master",
        "scenarios/hostile/test_slave_calls.py::test_publisher_updates_from_strangers",
        "scenarios/hostile/test_slave_calls.py::test_parameter_updates_from_strangers",
    ],
    "is obeyed only when the master no longer knows our URI": [
        "unit/node/graph/test_node_slave.py::test_a_shutdown_in_the_masters_name_is_checked",
    ],
    "`allow_shutdown=False` refuses `rosnode kill` too": [
        "unit/node/graph/test_node_slave.py::test_a_shutdown_by_a_person_is_obeyed_unless_it_is_not_allowed",
        "scenarios/hostile/test_slave_calls.py::test_shutdown_is_refused_where_it_is_not_allowed",
    ],
    "sends zero and cancels its goals before it closes": [
        "scenarios/test_holders.py::test_zero_is_sent_before_the_driving_node_is_shut_down",
        "scenarios/test_holders.py::test_goals_are_cancelled_before_their_node_is_shut_down",
    ],
    "so none leads out of that folder": [
        "scenarios/test_learn.py::test_no_name_leads_out_of_the_folder",
    ],
    "have the md5sum it was announced with, before and after it is written": [
        "scenarios/test_learn.py::test_a_lie_is_not_learned",
        "scenarios/test_learn.py::test_a_set_that_cannot_be_written_leaves_nothing",
    ],
    "one new folder for each set; no existing file is replaced": [
        "scenarios/test_learn.py::test_what_is_new_is_kept_once_and_used",
        "scenarios/test_learn.py::test_contradicting_definitions_go_into_different_sets",
    ],
    "`--dry-run` writes nothing": ["scenarios/test_learn.py::test_a_dry_run_writes_nothing"],
    "`--no-learned` and `Chassis(learned=False)` do without": [
        "unit/cli/test_own_definitions.py::test_a_service_of_another_revision_is_called",
    ],
    "commands no terminal and forges no line": [
        "scenarios/hostile/test_hostile_texts.py::test_no_command_lets_a_peer_write_to_the_terminal",
        "scenarios/hostile/test_hostile_chassis.py::test_what_a_chassis_says_when_it_refuses",
        "unit/cli/test_hostile_names.py::test_connections_of_a_bag",
        "unit/node/rosout/test_rosout_log.py::test_no_text_forges_a_record",
    ],
    "Retained orders and instant actions are not obeyed": [
        "interop/fleet/test_vehicle.py::test_a_retained_order_is_not_obeyed",
    ],
    "serial number or major version, or with a key twice, is refused": [
        "interop/fleet/test_refused.py::test_an_order_for_somebody_else_is_not_driven",
        "interop/fleet/test_refused.py::test_an_order_with_a_key_twice_is_not_driven",
        "unit/fleet/messages/test_parsing.py::test_a_message_for_somebody_else_is_invalid",
        "unit/fleet/messages/test_parsing.py::test_a_key_that_comes_twice_is_invalid",
    ],
    "is answered with `validationError` and changes nothing": [
        "interop/fleet/test_vehicle.py::test_what_does_not_fit_is_answered",
        "unit/fleet/messages/test_parsing.py::test_any_value_at_any_place_is_read_or_invalid",
        "unit/fleet/order/test_rejection.py::test_a_malformed_order_is_a_validation_error",
    ],
    "a flood takes no room from `cancelOrder` and `startPause`": [
        "unit/fleet/test_inbox.py::test_whatever_comes_the_last_of_each_stop_is_kept",
        "interop/fleet/test_floods.py::test_a_cancel_behind_a_flood_of_requests_is_obeyed",
    ],
    "64 messages that stop, 32 of other instant actions, 8 orders, 8 that do not fit": [
        "unit/fleet/test_inbox.py::test_a_full_lane_drops_what_comes_and_counts_it",
        "unit/fleet/messages/test_parsing.py::test_what_is_no_object_of_json_is_invalid",
        "unit/fleet/messages/test_parsing.py::test_an_order_of_too_many_nodes_is_invalid",
        "unit/fleet/test_vehicle.py::test_a_flood_of_messages_is_bounded",
        "interop/fleet/test_floods.py::test_a_flood_of_nonsense_is_survived",
    ],
    "at most 200 messages or 1 MB for a vehicle": [
        "unit/fleet/test_link.py::test_a_broker_that_does_not_read_costs_a_bounded_amount",
    ],
    "The broker is told to deliver no message that is longer (MQTT 5)": [
        "interop/fleet/test_floods.py::test_a_message_that_is_too_long_is_not_delivered",
    ],
    "an address that holds one is refused": [
        "unit/fleet/test_config.py::test_an_address_of_a_broker_holds_no_secret",
        "unit/fleet/test_config.py::test_secrets_are_in_a_file_of_ones_own",
    ],
    "get their parameters on standard input, through no shell": [
        "unit/fleet/actions/test_abilities.py::test_a_program_gets_the_parameters_and_gives_the_result",
    ],
    "given up for each new one, then the longest idle one": [
        "unit/transport/test_tcp_server.py::test_pending_handshakes_bounds_the_unready_and_drops_the_oldest",
        "unit/transport/test_tcp_server.py::test_the_longest_idle_connection_makes_room",
        "unit/transport/test_tcp_server.py::test_running_out_of_file_descriptors_is_survived_and_logged_once",
        "unit/master/test_master_server.py::test_silent_connections_that_take_every_file_keep_nobody_out",
    ],
    "off this computer it does not start without a token": [
        "unit/gateway/test_websocket_server.py::test_nobody_is_served_off_this_computer_without_a_token",
        "unit/gateway/test_websocket_server.py::test_tokens",
    ],
    "A web page from elsewhere is refused by its origin": [
        "unit/gateway/test_websocket_server.py::test_pages_from_elsewhere_are_refused",
        "unit/gateway/test_strangers.py::test_origins",
        "unit/gateway/test_strangers.py::test_hosts",
    ],
    "With `--authenticate` a rosbridge client is served only after the service": [
        "unit/gateway/test_rosbridge.py::test_a_client_is_served_after_its_credentials_are_accepted",
        "unit/gateway/test_rosbridge.py::test_anything_else_ends_the_connection",
        "unit/gateway/test_rosbridge.py::test_without_the_service_nobody_is_served",
        "unit/gateway/test_rosbridge.py::test_credentials_have_to_come_in_time",
    ],
    "Nothing is written through a gateway unless a pattern opens it": [
        "unit/gateway/test_access.py::test_everything_is_read_and_nothing_written_at_first",
        "unit/gateway/test_rosbridge.py::test_a_client_publishes_what_a_pattern_opens",
        "unit/gateway/test_rosbridge.py::test_services",
        "unit/gateway/test_rosbridge.py::test_goals",
    ],
    "is neither read, nor written, nor listed": [
        "unit/gateway/test_rosbridge.py::test_what_is_denied_is_neither_read_nor_listed",
        "unit/gateway/test_access.py::test_a_goal_denied_on_one_way_is_denied_on_the_other",
    ],
    "leaves or is silent for half a second, zero follows": [
        "unit/gateway/test_write_guard.py::test_over_real_sockets",
        "unit/gateway/test_rosbridge.py::test_zero_follows_when_a_driving_client_goes",
    ],
    "is published by no gateway, in whatever encoding it comes, and is no sign of life": [
        "unit/gateway/test_write_guard.py::test_a_velocity_that_is_none_is_refused",
        "unit/gateway/test_write_guard.py::test_what_is_no_velocity_is_no_sign_of_life",
        "unit/gateway/test_write_guard.py::test_no_client_publishes_past_the_guard",
        "unit/gateway/test_rosbridge.py::test_a_velocity_that_is_none_reaches_no_robot",
        "unit/gateway/foxglove/test_publishing.py::test_json_that_fits_nothing",
    ],
    "loses the oldest messages of its topics and costs bounded memory": [
        "unit/gateway/test_websocket_server.py::test_a_client_that_stops_reading_costs_nobody_else",
        "unit/gateway/test_outbox.py::test_bounds_hold_whatever_comes",
    ],
    "one that asks and does not read is cut off": [
        "unit/gateway/test_websocket_server.py::test_answers_that_are_not_read_end_the_connection",
    ],
    "gives no sign of life for twice `silence_seconds`": [
        "unit/gateway/test_websocket_server.py::test_a_client_that_gives_no_sign_of_life_is_given_up",
    ],
    "Connections that hold back their handshake make room for new ones": [
        "unit/gateway/test_websocket_server.py::test_connections_that_say_nothing_make_room_and_are_ended",
    ],
    "come and go leave no thread, file or topic": [
        "unit/gateway/test_websocket_server.py::test_hundreds_that_come_and_go_leave_nothing",
    ],
    "asks the system for 4096": [
        "unit/transport/test_open_files.py::test_it_is_raised_as_far_as_needed_and_allowed",
    ],
}
"""Words of the page, and the tests that hold them."""

RUNS_CODE = {
    "rosproto/codec/conversion.py": "values carried over between two revisions, from names of fields",
    "rosproto/codec/source.py": "encoders and decoders, from definitions",
    "rosproto/rospy/launch.py": "a program of the user's: `rosproto run`",
    "woosh_pure/cli/commands/shell.py": "what the user types: `woosh shell`",
}
"""Where Python code is made and run, and of what."""


def test_code_is_made_and_run_in_these_places_only() -> None:
    """No eval, no exec of remote text, no pickle: a new place has to be looked at, and named here."""
    root = Path(__file__).resolve().parent.parent
    found = set()
    for path in (*(root / "rosproto").rglob("*.py"), *(root / "woosh_pure").rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text("utf-8"))):
            called = isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id
            loads = {"pickle", "marshal", "shelve"} & {
                name.name.partition(".")[0] for name in (node.names if isinstance(node, ast.Import) else ())
            } or (isinstance(node, ast.ImportFrom) and node.module in ("pickle", "marshal", "shelve"))
            if called in ("eval", "exec") or loads:
                found.add(path.relative_to(root).as_posix())
    assert found == set(RUNS_CODE)


def rows(title: str) -> dict[str, str]:
    """Name -> default of one table."""
    table = PAGE.partition(f"| `{title}` field |")[2].partition("\n\n")[0]
    return dict(re.findall(r"^\| `(\w+)` \| ([\d.]+) \|", table, re.MULTILINE))


def test_limits() -> None:
    """The table is the class."""
    assert rows("Limits") == {name: str(value) for name, value in Limits._field_defaults.items()}


def test_definition_limits() -> None:
    """The table is the tuple."""
    expected = {name: str(value) for name, value in DefinitionLimits._field_defaults.items()}
    assert rows("DefinitionLimits") == expected


def test_gateway_limits() -> None:
    """The table is the tuple."""
    assert rows("GatewayLimits") == {name: str(v) for name, v in GatewayLimits._field_defaults.items()}


def test_bag_limits() -> None:
    """The table is the tuple."""
    assert rows("BagLimits") == {name: str(value) for name, value in BagLimits._field_defaults.items()}


HELD_BY = {
    "commands no terminal and forges no line": "scenarios/hostile/test_hostile_texts.py",
    "Every operation is bounded before it begins": "unit/cli/test_expression.py",
    "`BagLimits` field": "unit/bag/test_bag_limits.py",
    "is decoded within about 150 times": "unit/codec/test_amplification.py",
}
"""What the page says, and the tests that hold it."""


def test_what_is_said_is_held() -> None:
    """Each of these sentences stands on the page, and its tests are there."""
    for sentence, path in HELD_BY.items():
        assert sentence in PAGE, sentence
        assert "def test_" in (Path(__file__).resolve().parent / path).read_text("utf-8")


def test_every_limit_is_set_by_a_test() -> None:
    """A limit that nobody ever reached may not hold: some unit test or scenario makes each small and runs into it."""
    here = Path(__file__).resolve().parent
    tests = [
        path.read_text("utf-8") for room in ("unit", "scenarios") for path in (here / room).rglob("*.py")
    ]
    for kind in (Limits, DefinitionLimits, BagLimits, GatewayLimits):
        setting = [text for text in tests if kind.__name__ in text]
        names = kind._field_defaults
        untested = [name for name in names if not any(re.search(rf"\b{name}\b", text) for text in setting)]
        assert not untested, untested


def test_what_holds_a_sentence_is_there() -> None:
    """The words are still on the page, and so are the tests in their files."""
    here = Path(__file__).resolve().parent
    page = " ".join(PAGE.split())
    for words, tests in HOLDS.items():
        assert words in page, words
        for path, _, name in (test.partition("::") for test in tests):
            assert f"def {name}(" in (here / path).read_text("utf-8"), f"{path}::{name}"
