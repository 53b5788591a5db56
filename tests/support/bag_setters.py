"""A program that sets the compression and chunk_threshold of a rosbag.Bag and prints what it got."""

BAG_SETTERS = """
    import os
    import re
    import sys

    import rosbag
    from genpy import Time
    from std_msgs.msg import String

    path = os.path.join(os.path.dirname(os.path.abspath(sys.argv[0])), "set.bag")


    def refused(bag, name, value):
        try:
            setattr(bag, name, value)
        except ValueError as error:
            print(name, error)


    with rosbag.Bag(path, "w") as bag:
        for at, compression in enumerate(("none", "bz2", "lz4", "none")):
            bag.compression = compression
            for i in range(5):
                bag.write("/said", String("x" * 100), Time(1 + 10 * at + i))
        bag.chunk_threshold = 160
        for i in range(6):
            bag.write("/said", String("y" * 100), Time(100 + i))
        refused(bag, "compression", "zip")
        refused(bag, "chunk_threshold", -1)
        print(sorted(bag.options.items()))
    refused(bag, "compression", "bz2")
    refused(bag, "chunk_threshold", 1)
    with rosbag.Bag(path, "a") as bag:
        bag.compression = "bz2"
        bag.write("/said", String("z"), Time(200))
    with rosbag.Bag(path) as bag:
        bag.compression = "lz4"
        print(bag.compression, bag.get_message_count())
        print(re.findall("(none|bz2|lz4) .([0-9]+/[0-9]+) chunks", str(bag)))
        print([(m.data[0], t.secs) for _, m, t in bag.read_messages()])
"""
