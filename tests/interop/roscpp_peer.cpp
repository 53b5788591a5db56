// The roscpp nodes of the tests in this directory, in one program: what the compiler does with ros.h it does once.
//
//     roscpp_peer ROLE [ARGUMENT...]
#include <actionlib/client/simple_action_client.h>
#include <actionlib/TestAction.h>
#include <actionlib/server/simple_action_server.h>
#include <geometry_msgs/Pose2D.h>
#include <geometry_msgs/Twist.h>
#include <ros/ros.h>
#include <sensor_msgs/Image.h>
#include <sensor_msgs/LaserScan.h>
#include <std_msgs/Int32.h>
#include <std_msgs/String.h>
#include <std_srvs/Empty.h>
#include <std_srvs/SetBool.h>
#include <std_srvs/Trigger.h>
#include <woosh_msgs/MoveBaseAction.h>
#include <woosh_msgs/RobotStatus.h>
#include <woosh_msgs/StepControlAction.h>

#include <cstdio>
#include <cstdlib>
#include <map>
#include <memory>
#include <set>
#include <string>

static void say(const char *text) { puts(text); fflush(stdout); }

// -- actions ----------------------------------------------------------------------------------------------

typedef actionlib::SimpleActionServer<woosh_msgs::StepControlAction> Server;
typedef actionlib::SimpleActionClient<woosh_msgs::StepControlAction> Client;
static Server *server;

static void execute(const woosh_msgs::StepControlGoalConstPtr &goal) {
    woosh_msgs::StepControlFeedback feedback; feedback.percent = 0.5;
    woosh_msgs::StepControlResult result;
    server->publishFeedback(feedback);
    while (goal->mode == 2) {
        if (server->isPreemptRequested()) { result.percent = 9; server->setPreempted(result, "as you wish"); return; }
        ros::Duration(0.01).sleep();
    }
    if (goal->mode == 4) { server->setAborted(result, "cannot"); return; }
    result.percent = 7;
    server->setSucceeded(result, "well");
}

static int action_server(char **) {
    ros::NodeHandle handle;
    server = new Server(handle, "act", execute, false);
    server->start();
    say("up");
    ros::spin();
    return 0;
}

static int action_client(char **) {
    Client client("act", true);
    if (!client.waitForServer(ros::Duration(60))) { puts("no server"); return 1; }
    woosh_msgs::StepControlGoal goal;
    const int modes[] = {1, 3};
    for (int mode : modes) {
        goal.mode = mode;
        client.sendGoal(goal);
        if (!client.waitForResult(ros::Duration(60))) { puts("no result"); return 1; }
        printf("%s %g %s\n", client.getState().toString().c_str(), client.getResult()->percent,
               client.getState().getText().c_str());
    }
    goal.mode = 2;
    client.sendGoal(goal);
    while (client.getState() != actionlib::SimpleClientGoalState::ACTIVE) ros::Duration(0.01).sleep();
    client.cancelGoal();
    if (!client.waitForResult(ros::Duration(60))) { puts("no result"); return 1; }
    printf("%s %s\n", client.getState().toString().c_str(), client.getState().getText().c_str());
    return 0;
}

// A robot with an actionlib server for /move_base: it drives along x at 0.5 m/s, until it is there or preempted.
struct Mover {
    typedef actionlib::SimpleActionServer<woosh_msgs::MoveBaseAction> Server;
    ros::Publisher pose, velocity;
    boost::mutex lock;
    double x = 0.0, speed = 0.0;
    Server server;

    Mover(ros::NodeHandle handle) : server(handle, "move_base", boost::bind(&Mover::go, this, boost::placeholders::_1), false) {
        pose = handle.advertise<geometry_msgs::Pose2D>("movebase_pose2d", 10);
        velocity = handle.advertise<geometry_msgs::Twist>("odom_twist", 10);
        server.start();
    }
    void go(const woosh_msgs::MoveBaseGoalConstPtr &goal) {
        say("goal");
        bool there = false, preempted = false;
        while (ros::ok() && !there && !preempted) {
            boost::mutex::scoped_lock locked(lock);
            there = x >= goal->target_pose.pose.position.x;
            preempted = server.isPreemptRequested();
            speed = there || preempted ? 0.0 : 0.5;
            x += speed * 0.02;
            locked.unlock();
            ros::Duration(0.02).sleep();
        }
        say(preempted ? "preempted" : "arrived");
        if (preempted) server.setPreempted(); else server.setSucceeded();
    }
    void tell() {
        geometry_msgs::Pose2D place;
        geometry_msgs::Twist measured;
        { boost::mutex::scoped_lock locked(lock); place.x = x; measured.linear.x = speed; }
        pose.publish(place);
        velocity.publish(measured);
    }
};

static int robot(char **) {
    ros::NodeHandle handle;
    ros::Publisher status = handle.advertise<woosh_msgs::RobotStatus>("robot_status", 10, true);
    woosh_msgs::RobotStatus idle;
    idle.task_id = 1; idle.task_state = 7; idle.robot_state = 4; idle.robot_mode = 1; idle.work_mode = 2;
    status.publish(idle);
    Mover mover(handle);
    ros::AsyncSpinner spinner(1);
    spinner.start();
    say("up");
    for (ros::Rate rate(20); ros::ok(); rate.sleep()) mover.tell();
    return 0;
}

// One server for each name. A goal runs until its number is on /finish; one whose name begins with "obeys" also ends
// when it is preempted.
struct Holder {
    typedef actionlib::SimpleActionServer<actionlib::TestAction> Server;
    static std::set<int> finished;
    static boost::mutex lock;
    std::string name;
    Server server;

    Holder(ros::NodeHandle handle, const std::string &name)
        : name(name), server(handle, name, boost::bind(&Holder::execute, this, boost::placeholders::_1), false) {
        server.start();
    }
    static void finish(const std_msgs::Int32::ConstPtr &number) {
        boost::mutex::scoped_lock locked(lock);
        finished.insert(number->data);
    }
    static bool is_finished(int number) {
        boost::mutex::scoped_lock locked(lock);
        return finished.count(number) > 0;
    }
    void execute(const actionlib::TestGoalConstPtr &goal) {
        if (server.isPreemptRequested()) { server.setPreempted(); return; }
        while (!is_finished(goal->goal)) {
            if (!ros::ok()) return;
            if (name.rfind("obeys", 0) == 0 && server.isPreemptRequested()) { server.setPreempted(); return; }
            ros::Duration(0.005).sleep();
        }
        server.setSucceeded();
    }
};
std::set<int> Holder::finished;
boost::mutex Holder::lock;

static int action_holders(char **names) {
    ros::NodeHandle handle;
    ros::Subscriber subscriber = handle.subscribe("/finish", 1000, Holder::finish);
    std::vector<std::unique_ptr<Holder>> holders;
    for (; *names; ++names) holders.emplace_back(new Holder(handle, *names));
    say("up");
    ros::spin();
    return 0;
}

// -- services ---------------------------------------------------------------------------------------------

static bool set(std_srvs::SetBool::Request &request, std_srvs::SetBool::Response &response) {
    if (!request.data) throw std::runtime_error("the wheel is off");
    response.success = true;
    response.message = "set";
    return true;
}
static bool refuse(std_srvs::SetBool::Request &, std_srvs::SetBool::Response &) { return false; }
static bool die(std_srvs::Empty::Request &, std_srvs::Empty::Response &) { _exit(0); }

static int service_server(char **) {
    ros::NodeHandle node;
    auto a = node.advertiseService("/set", set);
    auto b = node.advertiseService("/refuse", refuse);
    auto c = node.advertiseService("/die", die);
    say("ready");
    ros::spin();
    return 0;
}

static int service_client(char **) {
    ros::NodeHandle node;
    printf("wait %d\n", (int)ros::service::waitForService("/ours", 60000));
    for (int persistent = 0; persistent < 2; ++persistent) {
        ros::ServiceClient client = node.serviceClient<std_srvs::SetBool>("/ours", persistent);
        for (int i = 0; i < 4; ++i) {
            std_srvs::SetBool call;
            call.request.data = (i != 2);
            bool ok = client.call(call);
            printf("call %d %d %d %s\n", persistent, i, (int)ok, call.response.message.c_str());
        }
        printf("valid %d %d\n", persistent, (int)client.isValid());
    }
    std_srvs::Trigger wrong;
    printf("wrong %d\n", (int)ros::service::call("/ours", wrong));
    say("done");
    return 0;
}

// -- topics -----------------------------------------------------------------------------------------------

template <class M> static int echo(bool unreliable) {
    ros::NodeHandle node;
    ros::Publisher out = node.advertise<M>("/out", 10);
    boost::function<void(const M &)> callback = [&out](const M &message) { out.publish(message); };
    ros::TransportHints hints;
    if (unreliable) hints.unreliable();
    ros::Subscriber in = node.subscribe<M>("/in", 10, callback, ros::VoidConstPtr(), hints);
    ros::spin();
    return 0;
}

static int topic_echo(char **arguments) {
    std::map<std::string, int (*)(bool)> known = {
        {"std_msgs/String", echo<std_msgs::String>},
        {"geometry_msgs/Twist", echo<geometry_msgs::Twist>},
        {"sensor_msgs/LaserScan", echo<sensor_msgs::LaserScan>},
        {"sensor_msgs/Image", echo<sensor_msgs::Image>},
        {"woosh_msgs/RobotStatus", echo<woosh_msgs::RobotStatus>},
    };
    return known.at(arguments[0])(arguments[1] != nullptr);
}

// -- parameters -------------------------------------------------------------------------------------------

static int parameter_echo(char **) {
    ros::NodeHandle node;
    XmlRpc::XmlRpcValue names, value;
    ros::param::get("/names", names);
    for (int i = 0; i < names.size(); ++i) {
        std::string name = names[i];
        if (!ros::param::get("/in/" + name, value)) { printf("cannot read %s\n", name.c_str()); continue; }
        ros::param::set("/out/" + name, value);
    }
    say("done");
    ros::spin();
    return 0;
}

// -- topics whose messages say when they were published: as TICKER in test_fresh_messages.py --------------

static std_msgs::String now() {
    char text[32];
    snprintf(text, sizeof text, "%.6f", ros::WallTime::now().toSec());
    std_msgs::String message; message.data = text;
    return message;
}

static int ticker(char **) {
    ros::NodeHandle node;
    ros::Publisher ticks = node.advertise<std_msgs::String>("/ticks", 10);
    ros::Publisher kept = node.advertise<std_msgs::String>("/kept", 10, true);
    kept.publish(now());
    boost::function<void(const std_msgs::String &)> go = [&](const std_msgs::String &) { kept.publish(now()); };
    ros::Subscriber asked = node.subscribe<std_msgs::String>("/go", 10, go);
    ros::WallTimer timer = node.createWallTimer(
        ros::WallDuration(0.1), [&](const ros::WallTimerEvent &) { ticks.publish(now()); });
    say("up");
    ros::spin();
    return 0;
}

// -- a bit of everything, for a master --------------------------------------------------------------------

static void heard(const std_msgs::String &m) { printf("cpp heard %s\n", m.data.c_str()); fflush(stdout); }

static int cpp_node(char **) {
    ros::NodeHandle n;
    auto sub = n.subscribe("chatter", 10, heard);
    auto pub = n.advertise<std_msgs::String>("cpp_chatter", 10, true);
    std_msgs::String m; m.data = "latched by cpp"; pub.publish(m);
    std::string value; n.setParam("/cpp/set", 42);
    ros::param::getCached("/cpp/watched", value);
    ros::WallTimer timer = n.createWallTimer(ros::WallDuration(0.02), [&](const ros::WallTimerEvent &) {
        std::string now; ros::param::getCached("/cpp/watched", now);
        if (now != value) { value = now; printf("cpp param %s\n", now.c_str()); fflush(stdout); }
    });
    say("cpp up");
    ros::spin();
    say("cpp down");
    return 0;
}

// -- ------------------------------------------------------------------------------------------------------

int main(int argc, char **argv) {
    struct Role { int (*run)(char **); uint32_t options; };
    std::map<std::string, Role> roles = {
        {"action_server", {action_server, ros::init_options::NoRosout}},
        {"action_client", {action_client, ros::init_options::NoRosout}},
        {"robot", {robot, ros::init_options::NoRosout}},
        {"action_holders", {action_holders, ros::init_options::NoRosout}},
        {"service_server", {service_server, 0}},
        {"service_client", {service_client, 0}},
        {"topic_echo", {topic_echo, ros::init_options::NoSigintHandler}},
        {"parameter_echo", {parameter_echo, 0}},
        {"ticker", {ticker, 0}},
        {"cpp_node", {cpp_node, 0}},
    };
    const std::string name = argc > 1 ? argv[1] : "";
    if (name == "md5sum") { say(ros::message_traits::md5sum<woosh_msgs::RobotStatus>()); return 0; }
    const Role role = roles.at(name);
    ros::init(argc, argv, name, role.options);
    return role.run(argv + 2);
}
