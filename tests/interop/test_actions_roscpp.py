"""Actions between us and roscpp's actionlib, both ways."""

from __future__ import annotations

import rosproto
from rosproto.action import ActionClient, ActionServer, GoalStatus
from tests.interop.test_actions_rospy import handler_for
from tests.support import ros

SERVER = r"""
#include <ros/ros.h>
#include <actionlib/server/simple_action_server.h>
#include <woosh_msgs/StepControlAction.h>
#include <cstdio>
typedef actionlib::SimpleActionServer<woosh_msgs::StepControlAction> Server;
Server *server;
void execute(const woosh_msgs::StepControlGoalConstPtr &goal) {
    woosh_msgs::StepControlFeedback feedback; feedback.percent = 0.5;
    woosh_msgs::StepControlResult result;
    server->publishFeedback(feedback);
    while (goal->mode == 2) {
        if (server->isPreemptRequested()) { result.percent = 9; server->setPreempted(result, "as you wish");
        return; } ros::Duration(0.01).sleep();
    }
    if (goal->mode == 4) { server->setAborted(result, "cannot"); return; }
    result.percent = 7;
    server->setSucceeded(result, "well");
}
int main(int argc, char **argv) {
    ros::init(argc, argv, "peer", ros::init_options::NoRosout);
    ros::NodeHandle handle;
    server = new Server(handle, "act", execute, false);
    server->start();
    puts("up"); fflush(stdout);
    ros::spin();
}
"""

CLIENT = r"""
#include <ros/ros.h>
#include <actionlib/client/simple_action_client.h>
#include <woosh_msgs/StepControlAction.h>
#include <cstdio>
typedef actionlib::SimpleActionClient<woosh_msgs::StepControlAction> Client;
int count = 0;
void feedback(const woosh_msgs::StepControlFeedbackConstPtr &) { ++count; }
int main(int argc, char **argv) {
    ros::init(argc, argv, "peer", ros::init_options::NoRosout);
    Client client("act", true);
    if (!client.waitForServer(ros::Duration(20))) { puts("no server"); return 1; }
    woosh_msgs::StepControlGoal goal;
    const int modes[] = {1, 3};
    for (int mode : modes) {
        goal.mode = mode;
        client.sendGoal(goal, Client::SimpleDoneCallback(), Client::SimpleActiveCallback(), feedback);
        if (!client.waitForResult(ros::Duration(10))) { puts("no result"); return 1; }
        printf("%s %.0f %s\n", client.getState().toString().c_str(), client.getResult()->percent,
               client.getState().getText().c_str());
    }
    goal.mode = 2;
    client.sendGoal(goal);
    while (client.getState() != actionlib::SimpleClientGoalState::ACTIVE) ros::Duration(0.01).sleep();
    client.cancelGoal();
    if (!client.waitForResult(ros::Duration(10))) { puts("no result"); return 1; }
    printf("%s %s\n", client.getState().toString().c_str(), client.getState().getText().c_str());
    return 0;
}
"""

ACTION = "woosh_msgs/StepControl"


def test_our_client_with_roscpps_simple_server(build_roscpp, our_master):
    program = build_roscpp("action_server", SERVER)
    with (
        ros.start_program(program, our_master.uri) as server,
        rosproto.Node("/ours", master_uri=our_master.uri, host="127.0.0.1") as node,
        ActionClient(node, "/act", ACTION) as client,
    ):
        server.wait_for("up")
        client.wait_for_server(20)
        handle = client.send_goal(client.type.goal(mode=1))
        assert handle.wait(10).percent == 7
        assert (handle.status, handle.text) == (GoalStatus.SUCCEEDED, "well")

        handle = client.send_goal(client.type.goal(mode=2))
        assert next(handle.feedback(10)).percent == 0.5
        assert handle.cancel()
        assert handle.wait(10).percent == 9
        assert (handle.status, handle.text) == (GoalStatus.PREEMPTED, "as you wish")

        handle = client.send_goal(client.type.goal(mode=4))
        handle.wait(10)
        assert (handle.status, handle.text) == (GoalStatus.ABORTED, "cannot")


def test_roscpps_simple_client_with_our_server(build_roscpp, our_master):
    program = build_roscpp("action_client", CLIENT)
    with (
        rosproto.Node("/ours", master_uri=our_master.uri, host="127.0.0.1") as node,
        ActionServer(node, "/act", ACTION, handler_for(ACTION)),
        ros.start_program(program, our_master.uri) as client,
    ):
        assert client.wait(60) == 0, client.output
        lines = [line for line in client.output.splitlines() if not line.startswith("[")]
    assert lines == ["SUCCEEDED 7 well", "ABORTED 0 RuntimeError: ours broke", "PREEMPTED as you wish"]
