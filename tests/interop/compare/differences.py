"""Where we differ from Debian's tools on purpose, each with its reason; a run counts how often each was met."""

from __future__ import annotations

import itertools
import json
import re
from collections import Counter
from collections.abc import Callable

from tests.interop.compare.bags import OUT_OF_RANGE, in_one_order, ties_in_one_order, without_connections
from tests.interop.compare.comparison import ERROR, Answer, Case, Difference, without_texts
from tests.interop.compare.definitions import unlike_anyone
from tests.interop.compare.links import STRING_MD5


def _refusals(answer: Answer) -> list[bool]:
    return [isinstance(step, dict) and ERROR in step for step in answer["steps"]]


def _both_refuse(case: Case, theirs: Answer, ours: Answer) -> bool:
    return _refusals(theirs) == _refusals(ours) and True in _refusals(ours)


def _in_case(pattern: str) -> Callable[[Case, Answer, Answer], bool]:
    expression = re.compile(pattern)
    return lambda case, theirs, ours: bool(expression.search(json.dumps(case, ensure_ascii=False)))


def _lists(case: Case, theirs: Answer, ours: Answer) -> bool:
    """Only the outputs of `list` differ."""
    steps = zip(case["steps"], theirs["steps"], ours["steps"], strict=True)
    different = [step["words"][0] for step, one, other in steps if one.get("out") != other.get("out")]
    return (
        theirs["tree"] == ours["tree"] and set(different) <= {"list", "get", "dump"} and "list" in different
    )


def _pretty_lists(case: Case, theirs: Answer, ours: Answer) -> bool:
    steps = zip(case["steps"], theirs["steps"], ours["steps"], strict=True)
    return all(
        one.get("out") == other.get("out")
        or ("-p" in step["words"] and re.search(r"\w: - ", one.get("out", "")))
        for step, one, other in steps
    )


def _crashes(case: Case, theirs: Answer, ours: Answer) -> bool:
    """A file holds no names and values, or an empty document."""
    return any(
        isinstance(one, dict)
        and one.get(ERROR) in ("TypeError", "AttributeError")
        and (step["words"][0] if isinstance(step, dict) else step[0]).startswith("load")
        for step, one in zip(case["steps"], theirs["steps"], strict=True)
    )


def _binary_in_list(case: Case, theirs: Answer, ours: Answer) -> bool:
    return theirs["tree"] == ours["tree"] and all(
        one.get("out") == other.get("out")
        or (one.get(ERROR) == "TypeError" and "!!binary" in other.get("out", ""))
        for one, other in zip(theirs["steps"], ours["steps"], strict=True)
    )


def _option(case: Case, theirs: Answer, ours: Answer) -> bool:
    return any(step["words"][0] == "set" and step["words"][-1].startswith("-") for step in case["steps"])


def _not_yaml(case: Case, theirs: Answer, ours: Answer) -> bool:
    """A text of the command line with a sign that YAML reserves, or a date."""
    return any(
        step["words"][0] == "set"
        and ERROR not in other
        and (
            one.get(ERROR) in ("ParserError", "ScannerError", "ConstructorError")
            or re.search(r"\? |#|\d{4}-\d\d-\d\d", step["words"][-1])
        )
        for step, one, other in zip(case["steps"], theirs["steps"], ours["steps"], strict=True)
    )


def _nameless(case: Case, theirs: Answer, ours: Answer) -> bool:
    return ERROR in ours and unlike_anyone(case["types"][case["main"]])


def _lenient(case: Case, theirs: Answer, ours: Answer) -> bool:
    return ERROR in theirs and "classes" in ours


def _bytes_left(case: Case, theirs: Answer, ours: Answer) -> bool:
    read = ours.get("read", {})
    return ERROR in read and "are left" in read["says"] and theirs.get("classes") is not None


def _not_there(case: Case, theirs: Answer, ours: Answer) -> bool:
    """genpy cuts a length at the end of the bytes, or makes thousands of messages of none."""
    read = theirs.get("read", {})
    return ERROR in ours.get("read", {}) and (
        len(read.get("text", "")) > 10_000 or not case["bytes"].startswith(read.get("bytes", "x"))
    )


def _large_nsecs(case: Case, theirs: Answer, ours: Answer) -> bool:
    both = [answer.get("read", {}).get("bytes", "") for answer in (theirs, ours)]
    return (
        bool(re.search("time|duration|Header", case["text"]))
        and len(both[0]) == len(both[1])
        and case["bytes"].startswith(both[1])
    )


def _exact_time(case: Case, theirs: Answer, ours: Answer) -> bool:
    if ERROR in theirs or ERROR in ours:
        return False
    both = [bytes.fromhex(answer["bytes"]) for answer in (theirs, ours)]
    apart = sum(one != other for one, other in zip(*both, strict=False))
    return (
        len(both[0]) == len(both[1])
        and apart <= 4
        and bool(re.search("Time|Duration|Status|stamp|seq|Header|frame_id", json.dumps(case)))
    )


def _they_refuse(pattern: str) -> Callable[[Case, Answer, Answer], bool]:
    """They refuse with this text, and we take it."""
    expression = re.compile(pattern)
    return lambda case, theirs, ours: (
        ERROR in theirs and ERROR not in ours and expression.search(theirs["says"]) is not None
    )


def _we_refuse(pattern: str) -> Callable[[Case, Answer, Answer], bool]:
    expression = re.compile(pattern)
    return lambda case, theirs, ours: (
        ERROR in ours and ERROR not in theirs and expression.search(ours["says"]) is not None
    )


def _we_say(pattern: str) -> Callable[[Case, Answer, Answer], bool]:
    return lambda case, theirs, ours: re.search(pattern, ours.get("says", "")) is not None


def _octets(case: Case, theirs: Answer, ours: Answer) -> bool:
    return case["type"] in ("std_msgs/UInt8MultiArray", "sensor_msgs/CompressedImage") and (
        "-p" in case["words"]
        or "b'" in theirs.get("out", "")
        or "[ord(x) for x in val]" in theirs.get("says", "")
    )


def _escaped(case: Case, theirs: Answer, ours: Answer) -> bool:
    return theirs.get("out", "").replace("\t", "\\t") == ours.get("out")


def _nested(case: Case, theirs: Answer, ours: Answer) -> bool:
    """The messages of an array that was asked for, or is in a message, are shortened."""
    words, out = case["words"], ours.get("out", "")
    arrays = (
        "--noarr" in words and "<array type:" in out and re.search(r"^ *- $", theirs.get("out", ""), re.M)
    )
    return "-p" not in words and bool(arrays or ("--nostr" in words and "<string length:" in out))


def _nan(case: Case, theirs: Answer, ours: Answer) -> bool:
    """Both have NaN, of another sign: Python's YAML library makes a negative one."""
    both = [
        re.sub("(f8ff|f87f|c0ff|c07f)", "nan", str(answer.get("bytes", answer.get("came", ""))))
        for answer in (theirs, ours)
    ]
    return "nan" in both[0] and both[0] == both[1]


def _ties(case: Case, theirs: Answer, ours: Answer) -> bool:
    return bool(
        without_texts({**ties_in_one_order(theirs), "says": "", "lines": sorted(theirs.get("lines", []))})
        == without_texts({**ties_in_one_order(ours), "says": "", "lines": sorted(ours.get("lines", []))})
    )


def _overlaps(case: Case, theirs: Answer, ours: Answer) -> bool:
    if case["ordered"] or ERROR in theirs or ERROR in ours:
        return False
    theirs, ours = in_one_order(theirs), in_one_order(ours)
    if case.get("start") or case.get(
        "end"
    ):  # rosbag.Bag searches in lists that are not sorted: it leaves some out
        return theirs["facts"] == ours["facts"] and all(row in ours["messages"] for row in theirs["messages"])
    return bool(without_texts({**theirs, "says": ""}) == without_texts({**ours, "says": ""}))


def _without_index(case: Case, theirs: Answer, ours: Answer) -> bool:
    return case["state"] != "sound" and (
        "unindexed" in str(theirs).lower() or case.get("allow_unindexed", False)
    )


def _overlapping_info(case: Case, theirs: Answer, ours: Answer) -> bool:
    """Only the lines of times and rates differ."""
    if case["ordered"] or "out" not in theirs or "out" not in ours:
        return False
    both = [
        [
            re.sub(r" +@ +[0-9.]+ .?Hz *| +", " ", line).strip("- ")
            for line in answer["out"].splitlines()
            if not re.match(" *(start|end|duration|frequency|(un)?compressed):", line)
        ]
        for answer in (theirs, ours)
    ]
    return [line for line in both[0] if line] == [line for line in both[1] if line] or "duration" in case[
        "words"
    ]


def _damaged(case: Case, theirs: Answer, ours: Answer) -> bool:
    """A byte of the bag was changed; an error of ours must be one of rosbag's."""
    problem = str(ours.get(ERROR) or (ours.get("ended") or {}).get(ERROR, ""))
    return case["state"] == "byte" and (not problem or problem.startswith(("ROSBag", "exit")))


def _unknown_type(case: Case, theirs: Answer, ours: Answer) -> bool:
    return "no_such_pkg" in str(theirs) + str(ours)


def _field_of_a_header(case: Case, theirs: Answer, ours: Answer) -> bool:
    """No field, one without a name, or one with an error."""
    return any("=" not in word or word.startswith(("=", "error=")) for word in case["header"])


def _length_of_a_frame(case: Case, theirs: Answer, ours: Answer) -> bool:
    """We received no more than what came before the first frame that has not the bytes that its string needs."""
    texts = {"050000000100000061": "a", "0400000000000000": ""}
    before = [texts[frame] for frame in itertools.takewhile(texts.__contains__, case["frames"])]
    received = ours["received"]
    return len(before) < len(case["frames"]) and received == before[: len(received)]


def _length_of_an_answer(case: Case, theirs: Answer, ours: Answer) -> bool:
    return "reply" in theirs and re.search("bytes at byte|are left", str(ours.get("why"))) is not None


def _md5sum_of_a_server(case: Case, theirs: Answer, ours: Answer) -> bool:
    return "reply" in theirs and "md5sum" in str(ours.get("why"))


def _md5sum_of_a_publisher(case: Case, theirs: Answer, ours: Answer) -> bool:
    """Its header has an md5sum that is not that of the subscriber's type, also an empty one."""
    (md5sum,) = {word for word in case["header"] if word.startswith("md5sum=")} or {""}
    return md5sum not in ("", "md5sum=*", f"md5sum={STRING_MD5}") and not ours["received"]


def _publisher_without_type(case: Case, theirs: Answer, ours: Answer) -> bool:
    return not theirs["received"] and not any(word.startswith("type=") for word in case["header"])


def _of_time_zero(case: Case, theirs: Answer, ours: Answer) -> bool:
    """The same without the messages of time 0, and in one order where several of a topic have one time."""
    if case["at_zero"] and not {"-s", "-u"}.isdisjoint(case["options"]):
        return True
    left = {topic: found[case["at_zero"].count(topic) :] for topic, found in ours["came"].items()}
    return _ties_sorted(case, {topic: found for topic, found in left.items() if found}) == _ties_sorted(
        case, theirs["came"]
    )


def _ties_sorted(case: Case, came: dict[str, list[str]]) -> dict[str, list[tuple[int, str]]]:
    """The messages of each topic with their times, those of one time sorted."""
    arranged = {}
    for topic, found in came.items():
        times = [stamp for stamp in case["times"].get(topic, ()) if stamp]
        # Of other messages than those of the bag in this span, the place is what can be told.
        arranged[topic] = sorted(
            zip(times if len(times) == len(found) else range(len(found)), found, strict=True)
        )
    return arranged


def _is_part(theirs: Answer, ours: Answer) -> bool:
    """Each topic of theirs has messages of ours, and no others."""
    return all(
        Counter(found) <= Counter(ours["came"].get(topic, ())) for topic, found in theirs["came"].items()
    )


def _latched_before(case: Case, theirs: Answer, ours: Answer) -> bool:
    """Only topics of latched connections differ."""
    came = [
        _ties_sorted(case, {t: found for t, found in answer["came"].items() if t not in case["latched"]})
        for answer in (theirs, ours)
    ]
    return "-s" in case["options"] and bool(case["latched"]) and came[0] == came[1]


def _copied_bytes(case: Case, theirs: Answer, ours: Answer) -> bool:
    """A definition is empty or no text of a definition: decoding and encoding loses the bytes."""
    both = [without_connections(answer).get("out.bag", {}).get("messages") for answer in (theirs, ours)]
    rows = [[[row[0], row[2]] for row in one or []] for one in both]
    return "p/Unusable" in str(ours) and bool(rows[0]) and sorted(rows[0]) == sorted(rows[1])


def _several_connections(case: Case, theirs: Answer, ours: Answer) -> bool:
    return case["shared"] and bool(
        _without_says(without_connections(theirs)) == _without_says(without_connections(ours))
    )


def _without_says(answer: Answer) -> Answer:
    return without_texts({**answer, "says": "", "lines": sorted(answer["lines"])})


def _more_is_saved(case: Case, theirs: Answer, ours: Answer) -> bool:
    """What they have, we have too."""
    (name,) = (key for key in ours if key not in ("lines", "says"))
    kept = without_connections(theirs[name]).get("messages", [])
    found = without_connections(ours[name]).get("messages", None)
    return found is not None and all(row in found for row in kept)


_NOT_YAML = _they_refuse(
    "start any token|2002:merge|while parsing|while scanning|'dict' object has no|datetime"
)
_BAG_KINDS = ("BagRead", "BagFilter", "BagReindex", "BagFix", "BagCompress")
_NAMELESS = "Constants without a usable name (`int8 =1`) are refused: no generator can make code of them."
_LENIENT = "Full texts of peers may have TABs, other lines of =, and faults in sections that nothing uses."

DIFFERENCES: list[Difference] = [
    Difference(
        "RosserviceCall",
        "Angles such as deg(90) are numbers here, too, as in parameters.",
        _in_case(r"(deg|rad)\("),
    ),
    Difference("Definition", _NAMELESS, _nameless),
    Difference("DefinitionByLayer", _NAMELESS, _nameless),
    Difference("FullText", _LENIENT, _lenient),
    Difference("FullTextByLayer", _LENIENT, _lenient),
    *[
        Difference(
            kind, "Fewer bytes than a length says are an error; genpy takes what is there.", _not_there
        )
        for kind in ("FullText", "FullTextByLayer")
    ],
    *[
        Difference(kind, "Times from the wire stay as they are, also with 1e9 nsecs and more.", _large_nsecs)
        for kind in ("FullText", "FullTextByLayer")
    ],
    Difference("Values", "A time in nanoseconds is exact; genpy computes with floats.", _exact_time),
    Difference(
        "Values",
        "1e3 and 1.5e3 are numbers, as in JSON; YAML 1.1 calls them text.",
        _in_case(r"\d[eE][-+]?\d|[-+]\.\d"),
    ),
    Difference(
        "Values", "Angles such as deg(90) are numbers here, too, as in parameters.", _in_case(r"(deg|rad)\(")
    ),
    Difference(
        "Values",
        "A number with a point is a time in seconds; genpy refuses it.",
        _they_refuse(r"args type: -?[0-9.]"),
    ),
    Difference(
        "Values",
        "A bool is 0 or 1; genpy sends any byte when nothing else is wrong.",
        _we_refuse("is not a bool"),
    ),
    Difference(
        "Values", "A text of the command line that is not YAML (@x, {a: #x}) is taken as it is.", _NOT_YAML
    ),
    Difference(
        "RosserviceCall",
        "A text of the command line that is not YAML (@x, {a: #x}) is taken as it is.",
        _NOT_YAML,
    ),
    Difference(
        "RosserviceCall",
        "A bool is 0 or 1; genpy sends any byte when nothing else is wrong.",
        _we_refuse("is not a bool"),
    ),
    Difference("Values", "3.0 fits a field of whole numbers.", _they_refuse("integer type")),
    Difference(
        "Publish",
        "A tuple of seconds and nanoseconds is a time; genpy fails.",
        _they_refuse("'tuple' object has no attribute 'secs'"),
    ),
    Difference(
        "Values",
        "null leaves a message as it is.",
        _they_refuse(r"args type: None|ascii string|No key named \[\]|\[None\]"),
    ),
    Difference(
        "Values",
        "An empty list is a message without fields.",
        _they_refuse(r"Given: \[\[\]\]\n \* Expected: \[\]"),
    ),
    Difference(
        "RosserviceCall",
        "null leaves a message as it is.",
        _they_refuse(r"args type: None|No key named \[\]|\[None\]"),
    ),
    Difference(
        "Reply",
        "Bytes for a string are sent as they are.",
        _they_refuse("'bytes' object has no attribute 'encode'"),
    ),
    Difference(
        "Publish",
        "Bytes for a string are sent as they are.",
        _they_refuse("'(bytes|bytearray)' object has no attribute 'encode'"),
    ),
    Difference(
        "RosserviceCall",
        "An empty list is a message without fields.",
        _they_refuse(r"Given: \[\[\]\]\n \* Expected: \[\]"),
    ),
    Difference(
        "RosserviceCall", "Negative numbers are values, not options.", _they_refuse("no such option: -[0-9.]")
    ),
    Difference(
        "RosserviceCall",
        "1e3 and 1.5e3 are numbers, as in JSON; YAML 1.1 calls them text.",
        _in_case(r"\d[eE][-+]?\d|[-+]\.\d"),
    ),
    Difference(
        "Cloud",
        "Debian's point_cloud2 fails where it means to warn.",
        _they_refuse("name 'sys' is not defined"),
    ),
    Difference(
        "RostopicEcho",
        "Control characters in CSV are escaped: a peer's text does not reach the terminal.",
        _escaped,
    ),
    Difference(
        "LiveEcho",
        "Control characters in CSV are escaped: a peer's text does not reach the terminal.",
        _escaped,
    ),
    Difference(
        "RostopicEcho",
        "uint8[] is printed as numbers, in columns of CSV and by itself; rostopic has no columns, and b''.",
        _octets,
    ),
    Difference(
        "LiveEcho",
        "uint8[] is printed as numbers, in columns of CSV and by itself; rostopic has no columns, and b'', or crashes.",
        _octets,
    ),
    Difference("RostopicEcho", "--nostr and --noarr shorten what is in arrays of messages, too.", _nested),
    Difference("LiveEcho", "--nostr and --noarr shorten what is in arrays of messages, too.", _nested),
    Difference("Values", "The sign of .nan, which has no meaning.", _nan),
    Difference("LivePub", "The sign of .nan, which has no meaning.", _nan),
    Difference("FullText", "Bytes behind the last field are an error; genpy ignores them.", _bytes_left),
    Difference(
        "RosparamCommand",
        "A file with one value, or with an empty document, is loaded; rosparam crashes.",
        _crashes,
    ),
    Difference(
        "RosparamFunctions", "A document that is not names and values is taken; rosparam crashes.", _crashes
    ),
    Difference(
        "RosparamCommand",
        "`param set NAME '- x'` takes the list; rosparam's parser takes it for an option.",
        _option,
    ),
    Difference(
        "RosparamCommand",
        "A text of the command line that is not YAML (@x, {a: #x}) is taken as it is.",
        _not_yaml,
    ),
    Difference(
        "RosparamCommand",
        "All values are checked before the first is set; rosparam sets some, then fails.",
        _both_refuse,
    ),
    Difference(
        "RosparamCommand",
        "`param list NAME` lists NAME itself, too, and nothing rather than an empty line.",
        _lists,
    ),
    Difference(
        "RosparamCommand", "`rosparam get -p` prints lists as `b: - 1`, which is not YAML.", _pretty_lists
    ),
    Difference(
        "RosparamCommand",
        "On a command line 1e3, 1.5e3 and -.5 are numbers, as in JSON; in YAML 1.1 they are text.",
        _in_case(r"\d[eE][-+]?\d|[-+]\.\d"),
    ),
    Difference(
        "RosparamCommand",
        "Binary data in a list is printed; rosparam ends with a TypeError.",
        _binary_in_list,
    ),
    *[
        Difference(
            kind,
            "Messages of the same time come in the order of the file; rosbag sorts them by connection.",
            _ties,
        )
        for kind in _BAG_KINDS
    ],
    *[
        Difference(
            kind,
            "Overlapping chunks are read in the order of time, as by rosbag play; rosbag.Bag reads chunk after chunk.",
            _overlaps,
        )
        for kind in _BAG_KINDS
    ],
    Difference(
        "BagInfo",
        "The first and last time of overlapping chunks are of all chunks; rosbag takes the first and the last chunk.",
        _overlapping_info,
    ),
    *[
        Difference(
            kind,
            "What is whole of a bag without an index is read; rosbag asks for reindex first.",
            _without_index,
        )
        for kind in ("BagRead", "BagInfo", "BagFilter", "BagCompress")
    ],
    Difference(
        "BagFilter",
        "An expression knows fields, and not Python's attributes such as m._type.",
        _we_say("is not a field"),
    ),
    Difference(
        "BagInfo",
        "A key that is not there is an error; rosbag prints one, and ends with 0.",
        lambda case, theirs, ours: theirs.get("out") == "" and "there is" in ours.get("says", ""),
    ),
    *[
        Difference(kind, "A changed byte of a bag is told, or read as it stands.", _damaged)
        for kind in (*_BAG_KINDS, "BagInfo")
    ],
    *[
        Difference(
            kind,
            "A definition that names an unknown type ends rosbag's reading; ours goes on.",
            _unknown_type,
        )
        for kind in _BAG_KINDS
    ],
    *[
        Difference(
            kind,
            "Each connection of a topic is kept; rosbag.Bag writes messages of a topic under another of its connections.",
            _several_connections,
        )
        for kind in _BAG_KINDS[1:]
    ],
    *[
        Difference(kind, reason, _more_is_saved)
        for kind, reason in (
            ("BagReindex", "What is whole in a chunk that is cut off is kept; rosbag cuts it off."),
            (
                "BagFix",
                "fix saves every readable message as it is; rosbag fix translates into the system's definitions.",
            ),
        )
    ],
    Difference(
        "BagFilter",
        "filter copies bytes as they are; rosbag decodes and encodes them, also without a definition.",
        _copied_bytes,
    ),
    *[
        Difference(
            kind,
            "A connection header with a field that is none, or has an error, is refused in words; rospy closes, or takes it.",
            _field_of_a_header,
        )
        for kind in ("ToPublisher", "ToService", "FromService", "FromPublisher")
    ],
    Difference(
        "FromPublisher",
        "A publisher with another md5sum, or an empty one, is refused; rospy and roscpp do not look.",
        _md5sum_of_a_publisher,
    ),
    Difference(
        "FromPublisher",
        "A publisher whose header has no type is taken; rospy refuses it.",
        _publisher_without_type,
    ),
    Difference(
        "FromPublisher",
        "A message with fewer or more bytes than its fields need is an error, after those before it; genpy takes what is"
        " there, or drops all that came with it.",
        _length_of_a_frame,
    ),
    Difference(
        "FromService",
        "A response with fewer or more bytes than its fields need is an error; genpy takes what is there.",
        _length_of_an_answer,
    ),
    Difference(
        "FromService", "A server with another md5sum is refused; rospy does not look.", _md5sum_of_a_server
    ),
    Difference(
        "FromService",
        "A server whose header has no type is taken; rospy refuses it.",
        lambda case, theirs, ours: "missing required field [type]" in str(theirs) and "reply" in ours,
    ),
    Difference(
        "ToService",
        "A request with fewer or more bytes than its fields need is answered by an error; rospy takes it, or never answers.",
        lambda case, theirs, ours: not {"", "0100"}.isdisjoint(case["calls"]) and "bytes" in str(ours),
    ),
    Difference(
        "BagPlay",
        "Of two definitions on one topic one is played; rosbag sends the bytes of both under one type.",
        lambda case, theirs, ours: case["shared"] and "different definitions" in ours["says"],
    ),
    Difference(
        "BagPlay",
        "Messages of time 0 are played, and -s and -u count from them; rosbag does not load them. Others of one time "
        "come in the order of the file; rosbag begins with the connection that was recorded last, and its sort decides.",
        _of_time_zero,
    ),
    Difference(
        "BagPlay",
        "A span that comes near the last time of ROS (2106) is played to the last message; rosbag ends with 'Time is out "
        "of dual 32-bit range', and what it has sent just before is lost now and then.",
        lambda case, theirs, ours: theirs["says"] == OUT_OF_RANGE and _is_part(theirs, ours),
    ),
    Difference(
        "BagPlay",
        "With -s the last message that was latched before is played first, once; rosbag play sends it twice, or not at all.",
        _latched_before,
    ),
    Difference(
        "BagPlay",
        "Overlapping chunks are played to the last message; rosbag play ends earlier.",
        lambda case, theirs, ours: (
            not case["ordered"]
            and all(
                found == ours["came"].get(topic, [])[: len(found)] for topic, found in theirs["came"].items()
            )
        ),
    ),
    Difference(
        "LiveEcho",
        "--noarr and --nostr leave the field that was asked for, live as from a bag; rostopic only from a bag.",
        lambda case, theirs, ours: (
            case["words"][0] != ""
            and not {"--noarr", "--nostr"}.isdisjoint(case["words"])
            and "length: " in theirs.get("out", "")
        ),
    ),
    Difference(
        "LivePub",
        "pub takes values that rostopic refuses (1e3, @x, deg(90)); the kind Values has the reason of each.",
        lambda case, theirs, ours: not theirs.get("came") and bool(ours.get("came")),
    ),
]
