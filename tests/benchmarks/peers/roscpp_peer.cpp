// One role of a benchmark, in roscpp: `roscpp_peer ROLE seconds count hz queue_size nodelay`. See python_peer.py.
#include <geometry_msgs/Twist.h>
#include <ros/ros.h>
#include <sys/resource.h>
#include <time.h>

#include <atomic>
#include <cstdio>
#include <string>
#include <thread>
#include <vector>

static double now() {
  timespec t;
  clock_gettime(CLOCK_MONOTONIC, &t);
  return t.tv_sec + t.tv_nsec * 1e-9;
}
static double cpu() {
  rusage u;
  getrusage(RUSAGE_SELF, &u);
  return u.ru_utime.tv_sec + u.ru_stime.tv_sec + (u.ru_utime.tv_usec + u.ru_stime.tv_usec) * 1e-6;
}
static void say_times(const std::vector<double>& times, size_t skip) {
  std::printf("{\"times\": [");
  for (size_t i = skip; i < times.size(); ++i) std::printf("%s%.1f", i > skip ? ", " : "", times[i] * 1e6);
  std::printf("]}\n");
  std::fflush(stdout);
}
static void ready() {
  std::printf("{\"ready\": true}\n");
  std::fflush(stdout);
}

int main(int argc, char** argv) {
  std::string role = argv[1];
  double seconds = atof(argv[2]);
  int count = atoi(argv[3]);
  double hz = atof(argv[4]);
  int queue = atoi(argv[5]);
  bool nodelay = atoi(argv[6]);
  ros::init(argc, argv, "roscpp_" + role, ros::init_options::AnonymousName | ros::init_options::NoSigintHandler);
  ros::NodeHandle node;
  ros::TransportHints hints;
  if (nodelay) hints.tcpNoDelay();
  ros::AsyncSpinner spinner(1);
  spinner.start();
  geometry_msgs::Twist twist;
  auto wait = [](ros::Publisher& pub) {
    while (pub.getNumSubscribers() < 1) usleep(10000);
    usleep(300000);
  };
  if (role == "publish_fast") {
    ros::Publisher pub = node.advertise<geometry_msgs::Twist>("/bench", queue);
    wait(pub);
    double begin = now(), busy = cpu();
    long sent = 0;
    while (now() < begin + seconds)
      for (int i = 0; i < 100; ++i, ++sent) pub.publish(twist);
    std::printf("{\"sent\": %ld, \"seconds\": %f, \"cpu\": %f}\n", sent, now() - begin, cpu() - busy);
    std::fflush(stdout);
    usleep(700000);
  } else if (role == "count") {
    std::atomic<long> received(0);
    boost::function<void(const geometry_msgs::Twist&)> callback = [&](const geometry_msgs::Twist&) { ++received; };
    ros::Subscriber sub = node.subscribe<geometry_msgs::Twist>("/bench", queue, callback, ros::VoidConstPtr(), hints);
    ready();
    while (!received) usleep(1000);
    double begin = now(), last = begin, busy = cpu(), last_cpu = busy;
    long start = received, seen = start;
    while (true) {
      usleep(20000);
      if (received != seen) {
        seen = received;
        last = now();
        last_cpu = cpu();
      } else if (now() - last > 0.5) {
        break;
      }
    }
    std::printf("{\"received\": %ld, \"seconds\": %f, \"cpu\": %f}\n", seen - start, last - begin, last_cpu - busy);
  } else if (role == "ping") {
    std::atomic<bool> came(false);
    double sent = 0;
    std::vector<double> times;
    boost::function<void(const geometry_msgs::Twist&)> callback = [&](const geometry_msgs::Twist&) {
      times.push_back(now() - sent);
      came = true;
    };
    ros::Subscriber sub = node.subscribe<geometry_msgs::Twist>("/pong", queue, callback, ros::VoidConstPtr(), hints);
    ros::Publisher pub = node.advertise<geometry_msgs::Twist>("/ping", queue);
    wait(pub);
    usleep(700000);
    for (int i = 0; i < count + 200; ++i) {
      came = false;
      sent = now();
      pub.publish(twist);
      while (!came && now() - sent < 2) usleep(20);
    }
    say_times(times, 200);
  } else if (role == "pong") {
    ros::Publisher pub = node.advertise<geometry_msgs::Twist>("/pong", queue);
    boost::function<void(const geometry_msgs::Twist&)> callback = [&](const geometry_msgs::Twist& m) { pub.publish(m); };
    ros::Subscriber sub = node.subscribe<geometry_msgs::Twist>("/ping", queue, callback, ros::VoidConstPtr(), hints);
    ready();
    usleep(seconds * 1e6);
  } else if (role == "publish_steady") {
    ros::Publisher pub = node.advertise<geometry_msgs::Twist>("/bench", queue);
    wait(pub);
    double due = now();
    for (int i = 0; i < count; ++i) {
      due += 1 / hz;
      if (due > now()) usleep((due - now()) * 1e6);
      twist.linear.x = now();
      pub.publish(twist);
    }
    std::printf("{\"sent\": %d}\n", count);
    std::fflush(stdout);
    usleep(700000);
  } else if (role == "one_way") {
    std::vector<double> times;
    boost::function<void(const geometry_msgs::Twist&)> callback = [&](const geometry_msgs::Twist& m) {
      times.push_back(now() - m.linear.x);
    };
    ros::Subscriber sub = node.subscribe<geometry_msgs::Twist>("/bench", queue, callback, ros::VoidConstPtr(), hints);
    ready();
    size_t last = 0;
    for (double end = now() + 60; now() < end;) {
      usleep(600000);
      if (times.size() && times.size() == last) break;
      last = times.size();
    }
    say_times(times, times.size() / 10);
  }
  std::fflush(stdout);
  _exit(0);
}
