"""Status codes: the meaning of a number on /status_code, and the active faults. Pure: no clock, no network.

A code has 12 decimal digits: version (1), department (1), module (2), submodule (2), function state (5),
level (1). Level 0 means normal or recovered and clears the other codes of the same submodule; submodule 00
clears its module.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from enum import IntEnum
from functools import lru_cache
from importlib import resources

from rosproto.sentence import both, say
from woosh_pure.enums import RobotState

__all__ = [
    "ActiveFaults",
    "Department",
    "FaultLevel",
    "Faults",
    "StatusCode",
    "all_codes",
    "chinese",
    "decode_status_code",
    "english",
    "with_words",
]

# Words of the identifiers in English and Chinese. Only words whose spelling does not read as plain English
# are listed for English. The vendor's misspellings (ABNOR, SEANNER, SUCESS, ININT ...) are keys, because the
# identifiers contain them.
_ENGLISH = dict(
    pair.split("=")
    for pair in (
        "ABNOR=abnormal,ABNORMAL=abnormal,COMM=communication,DISCON=disconnected,DRV=drive,MOT=motor,"
        "CTRL=control,CONTRO=control,"
        "NAV=navigation,MAG=magnetic,EXEC=execution,FAC=vendor,POWERMNG=power management,EXT=external,"
        "ST=state,VLT=voltage,"
        "TEMP=temperature,CUR=current,SPD=speed,OVTMP=over-temperature,OVLOAD=overload,ENCODE=encoder,"
        "ESB=emergency stop button,"
        "SEANNER=safety scanner,CRASH=bumper,HW=hardware,CMD=command,HI=high,LIFTR=rotary lift,SEQ=unit,"
        "UVW=phase wiring,"
        "RGBLED=light strip,AR=visual tag,INIT=initialisation,ININT=initialise,SUCESS=success,STATR=start,"
        "STATRTING=starting,"
        "UNFIND=not found,UNDETECT=not detected,DIR=folder,POS=position,INFO=information,RF=radio,"
        "REQ=request,"
        "DMS=dispatch system,LAN=network,UNSAFT=unsafe,UNSTART=not started,NOTAVAILABLE=no available,"
        "OUTOF=out of,"
        "OCCUPIED=occupied,STUDY=learning,STRAND=stuck,GETOUT=get out,DOCKINGD=docking,WORMHOLES=map link,"
        "DISTURB=interrupted,"
        "PREEMPT=preempted,LOC=location,HANG=hoist,QRCODE=QR code,MOVEBASE=move base,EXIST=exists,"
        "TASKING=task running,"
        "DETECT=detection,CODE=code,CALL=call,CAUSE=because of,CASE=because,SERVER=server,SDK=SDK,JSON=JSON,"
        "WIFI=Wi-Fi,"
        "IMU=IMU,UWB=UWB,BMS=BMS,PLC=PLC,SLAM=SLAM,IP=IP,ID=ID"
    ).split(",")
)

_CHINESE = dict(
    pair.split("=")
    for pair in (
        "SEQ=单元,FAILED=失败,SONAR=超声波,ABNOR=异常,COMM=通讯,CALL=调用,DRIVER=驱动器,NORMAL=正常,"
        "MAP=地图,DISCON=断开,DOCK=对接,"
        "ROLLER=滚筒,NOT=未,START=启动,DETECT=检测,CTRL=控制,NAV=导航,LOCALIZATION=定位,CAUSE=原因,"
        "LIFT=升降,TO=,REBOOT=重启,"
        "READY=就绪,TIMEOUT=超时,DRV=驱动,LIFTR=旋转升降,MOT=电机,SLAVE=从机,NARROW=窄通道,MAG=磁导航,"
        "SECONDARY=二次,OVER=过,"
        "HANG=悬挂,BARRIER=障碍,STEP=单步,STATUS=状态,TRACTOR=牵引,CANCEL=取消,LOAD=加载,MAGNETISM=磁传感器,"
        "PASSAGES=通道,ERROR=错误,"
        "ELEVATOR=电梯,SUCCESS=成功,EXEC=执行,PAUSE=暂停,CONTINUE=继续,LIDAR=激光,FAC=厂家,CODE=代码,"
        "POWERMNG=电源管理,CHECK=检查,"
        "CHARGER=充电器,MOVE=移动,ENTER=进入,SCENE=场景,MODE=模式,EXIT=退出,CHARGE=充电,AVOID=避障,"
        "SWITCH=切换,SAFETY=安全,"
        "INIT=初始化,MAPPING=建图,PLANNER=规划器,MODIFY=修改,TRIGGER=触发,LOW=低,ST=状态,UNREACHABLE=不可达,"
        "POSITION=位置,AR=视觉标签,"
        "TRACK=跟踪,EMPTY=为空,NAME=名称,TASK=任务,VLT=电压,EXT=外部,HARDWARE=硬件,OCCUPIED=被占用,"
        "BASE=底盘,LEAVING=离开,"
        "LIFTING=举升,ROTATE=旋转,AVOIDING=避障中,UNFIND=未找到,STATE=状态,TRACTION=牵引,ARM=机械臂,"
        "UPDATE=更新,SAVE=保存,SYSTEM=系统,"
        "HALL=霍尔,TEMP=温度,LASER=激光雷达,FEEDBACK=反馈,PROCESS=过程,END=结束,DISTURB=打断,PREEMPT=抢占,"
        "OBSTACLES=障碍物,"
        "RECOGNIZE=识别,QRCODE=二维码,INFO=信息,SETTING=设置,SPD=速度,STOP=停止,CAMERA=相机,IMU=惯性单元,"
        "LIMIT=限位,LOCAL=局部,NO=无,"
        "CONNECT=连接,SCAN=扫描,DIR=目录,MAIN=主控,CUR=电流,RGBLED=灯带,UWB=超宽带,SPEED=速度,GLOBAL=全局,"
        "CALIBRATION=校准,"
        "MECHANISM=机构,USING=使用,EXIST=存在,DELETE=删除,ESB=急停按钮,UVW=相线,ENCODE=编码器,OTHER=其他,"
        "UNDETECT=未检测到,POINT=点,"
        "TURN=打开,DOCKING=对接,VERIFY=校验,ROUTE=路线,WORMHOLES=地图连接点,OPEN=打开,FIELD=区域,ON=,"
        "ABNORMAL=异常,CLOSE=关闭,"
        "CHANGE=更改,CRASH=防撞条,SEANNER=安全扫描仪,UP=上升,DOWN=下降,POSE=位姿,BLOCK=堵转,STUDY=学习,"
        "GROUP=组,TEMPORARY=临时,"
        "FAILURE=故障,BREAK=中断,MOVEBASE=底盘导航,NAVIGATION=导航,ID=编号,CREATE=创建,ACTION=动作,"
        "FILE=文件,WRITE=写入,SET=设置,"
        "WORK=工作,PLC=PLC,OVTMP=过温,OVLOAD=过载,HW=硬件,CMD=指令,HI=高,STRAND=卡死,MASTER=主机,LOGIC=逻辑,"
        "SYNC=同步,NEAR=附近,"
        "DOCKINGD=对接,VERIFYING=校验,GETOUT=驶出,FIND=查找,CARTOGRAPHER=建图定位,FETCH=取货,FEED=送货,"
        "RECOGNITION=识别,LAN=网络,"
        "WIFI=无线网,DMS=调度系统,POS=位置,INCORRECT=不正确,TYPE=类型,SUCCEED=成功,WARNING=警告,PARK=泊车,"
        "RF=射频,DATA=数据,"
        "DETECTED=检测到,RACK=货架,OFFSET=偏移,BUFFER=缓存,SLAM=SLAM,UPLOAD=上传,TASKING=任务中,"
        "ININT=初始化,CONTACTOR=接触器,"
        "POWER=电源,BMS=电池管理,DRIFT=漂移,BEACON=信标,OUT=超出,OF=,SUCESS=成功,TARGET=目标,ROBOT=机器人,"
        "IN=在,STATIC=静态,"
        "WAITING=等待,PERMISSION=许可,INITIAL=初始,JUMP=跳变,STATR=启动,AHEAD=前方,TOO=过,STATRTING=起步,"
        "GO=行驶,STRAIGHT=直行,"
        "RIGHT=右,LEFT=左,RECOVERY=恢复,OUTOF=超出,MOVING=移动,RANGE=范围,FAIL=失败,RECEIVE=接收,IMAGE=图像,"
        "HAVE=有,UNSTART=未启动,"
        "UNKNOWN=未知,LOCATIONS=位置,LOADED=加载,RECORD=记录,RESTORATION=恢复,SAVED=保存,NEIGHBOR=相邻,"
        "GRATING=光栅,DETECTS=检测到,"
        "OBSTACLE=障碍物,FLOOR=楼层,FILTER=过滤,AUTODOOR=自动门,AVAILABLE=可用,SPOT=位,ENABLED=启用,"
        "BATTERY=电量,DURING=处于,"
        "CHARGING=充电,TIME=时间,NOTAVAILABLE=无可用,PILE=桩,CONTRO=控制,UNSAFT=不安全,FORWARD=前进,"
        "BACKWARD=后退,PARAMETERS=参数,"
        "SERVER=服务,LOCATION=定位,LOST=丢失,NONE=无,UPDATED=更新,NEED=需要,ONLY=唯一,SAME=相同,JSON=JSON,"
        "SDK=SDK,VERSION=版本,"
        "ORDER=指令,DEPLOYMENT=部署,REQ=请求,EXECUTION=执行,CASE=原因,PARSING=解析,COMPLETED=完成,FIRE=火警,"
        "TRIGGERED=触发,CARGO=货物,"
        "ACCEPT=接受,WAIT=等待,MODEL=模型,THE=,PROTECTION=保护,GET=获取,IP=IP,AUTO=自动,MANUAL=手动,"
        "MAINTAIN=维护,OR=或,BUTTON=按钮"
    ).split(",")
)


def _split(word: str) -> tuple[str, str]:
    stem = word.rstrip("0123456789")
    return stem, word[len(stem) :]


def english(words: list[str]) -> str:
    """The words of an identifier as an English phrase."""
    parts = []
    for word in words:
        stem, number = _split(word)
        parts.append(_ENGLISH.get(stem, stem.lower()) + (f" {number}" if number else ""))
    return " ".join(p for p in parts if p)


def chinese(words: list[str]) -> str:
    """The words of an identifier as a Chinese phrase; a word without translation stays as it is."""
    return "".join(_CHINESE.get(stem, stem) + number for stem, number in map(_split, words))


class FaultLevel(IntEnum):
    """Last digit of a code (our reading of the table)."""

    NORMAL = 0
    NOTICE = 1
    WARNING = 2
    SEVERE = 3


class Department(IntEnum):
    """Second digit of a code: the part of the robot."""

    UNKNOWN = 0
    ELECTRICAL = 1
    EMBEDDED = 2
    SYSTEM = 3
    APPLICATION = 4


@dataclass(frozen=True, slots=True)
class _VendorWords:
    """The words of a status code: the vendor's table has them in both languages."""

    english: str
    chinese: str

    def __str__(self) -> str:
        return self.english

    def said(self, language: str) -> str:
        """Return the text in a language of `woosh_pure.language`."""
        return self.chinese if language == "zh" else self.english


@dataclass(frozen=True, slots=True)
class StatusCode:
    """One decoded code.

    Attributes:
        code: The number on the wire.
        identifier: The vendor's name for it, "" when the table has none.
        english, chinese: One short sentence.
        derived: True when the sentence is made from the identifier (or from the number) alone.
        level: Its severity.
        department: The part of the robot.
        module, submodule: Two digits each.
        function_state: Five digits.
        version: First digit.
        other_identifiers: Further names of the same number (one code of the table has two).
    """

    code: int
    identifier: str
    english: str
    chinese: str
    derived: bool
    level: FaultLevel
    department: Department
    module: int
    submodule: int
    function_state: int
    version: int
    other_identifiers: tuple[str, ...] = ()

    @property
    def known(self) -> bool:
        """True when the vendor's table has this code."""
        return bool(self.identifier)

    @property
    def is_fault(self) -> bool:
        """True for warnings and severe codes."""
        return self.level >= FaultLevel.WARNING

    @property
    def source(self) -> tuple[int, int, int, int]:
        """(version, department, module, submodule): what a level-0 code clears."""
        return (self.version, self.department, self.module, self.submodule)

    def __str__(self) -> str:
        return say("{words} ({code})", words=_VendorWords(self.english, self.chinese), code=self.code)


@lru_cache(maxsize=1)
def _table() -> dict[int, list[object]]:
    text = resources.files("woosh_pure").joinpath("data/status_codes.json").read_text(encoding="utf-8")
    return {int(code): entry for code, entry in json.loads(text).items()}


def all_codes() -> Iterator[StatusCode]:
    """Every code of the vendor's table, decoded."""
    return map(decode_status_code, _table())


@lru_cache(maxsize=1024)
def decode_status_code(code: int) -> StatusCode:
    """Decode a number of /status_code; any uint64 is valid, and unknown ones have `known` False."""
    entry = _table().get(code)
    identifiers, en, zh, derived = _texts(code, entry)
    digits = f"{code:012d}"
    regular = len(digits) == 12
    level = int(digits[11]) if regular else FaultLevel.NOTICE
    return StatusCode(
        code=code,
        identifier=identifiers[0] if identifiers else "",
        english=en,
        chinese=zh,
        derived=derived,
        level=FaultLevel(level) if level <= FaultLevel.SEVERE else FaultLevel.WARNING,
        department=_department(digits) if regular else Department.UNKNOWN,
        module=int(digits[2:4]) if regular else 0,
        submodule=int(digits[4:6]) if regular else 0,
        function_state=int(digits[6:11]) if regular else 0,
        version=int(digits[0]) if regular else 0,
        other_identifiers=tuple(identifiers[1:]),
    )


def with_words(text: str) -> str:
    """Return a chassis's text about a goal with the words of its code ("status code 110201000013")."""
    found = re.search(r"status code (\d{6,20})(?! \()", text)
    if found is None:
        return text
    code = decode_status_code(int(found[1]))
    if text == found[0]:
        words = _VendorWords(code.english, code.chinese)
        return say("status code {code} ({words})", code=found[1], words=words)
    return text.replace(found[0], f"{found[0]} ({code.english})")


def _department(digits: str) -> Department:
    number = int(digits[1])
    return Department(number) if number <= Department.APPLICATION else Department.UNKNOWN


def _texts(code: int, entry: list[object] | None) -> tuple[list[str], str, str, bool]:
    if entry is None:
        return [], f"unknown code {code}", f"未知状态码 {code}", True
    identifiers = [str(name) for name in entry[0]]  # type: ignore[attr-defined]
    if len(entry) == 3:
        return identifiers, str(entry[1]), str(entry[2]), False
    words = [name.split("_")[1:] for name in identifiers]
    return identifiers, " or ".join(map(english, words)), "或".join(map(chinese, words)), True


class Faults(tuple[StatusCode, ...]):
    """Received faults that have not ended, the worst first, and whether there are no others.

    Codes are sent on change only, so earlier ones are not received. The state of the robot shows whether
    there are any: a robot that is idle or has a task has no fault.

    Attributes:
        robot_state: The last reported state, None if none was received.
    """

    robot_state: RobotState | None

    def __new__(cls, codes: Iterable[StatusCode] = (), robot_state: RobotState | None = None) -> Faults:
        made = super().__new__(cls, codes)
        made.robot_state = robot_state
        return made

    @property
    def known(self) -> bool:
        """True when the robot's state shows that there are no other faults."""
        state = self.robot_state
        return state is not None and state.known and state not in _NOT_WELL

    @property
    def present(self) -> bool | None:
        """Whether there is a fault: True, False, or None when that is not known."""
        if self or self.robot_state in (RobotState.WARNING, RobotState.FAULT):
            return True
        return False if self.known else None

    def sentence(self) -> str:
        """Describe the faults in one line."""
        if self:
            return both(*map(str, self))
        if self.present:
            return say(
                "the robot reports a {state}; its code was not heard, look at its display",
                state=self.robot_state,
            )
        return "none" if self.known else NOT_KNOWN


_NOT_WELL = (RobotState.UNDEFINED, RobotState.UNINITIALISED, RobotState.WARNING, RobotState.FAULT)
NOT_KNOWN = (
    "not known: no code was heard (they are sent on change only), and the robot has not told its state"
)


class ActiveFaults:
    """The set of currently active faults, kept from the codes as they come.

    Several nodes publish on /status_code; each code stands for its submodule, so merging them is safe.
    Not thread-safe: the owner holds a lock.
    """

    def __init__(self) -> None:
        self._active: dict[int, tuple[StatusCode, frozenset[object]]] = {}
        self._before: dict[int, StatusCode] = {}

    def receive(self, code: int, links: frozenset[object] = frozenset()) -> StatusCode:
        """Take in one code and return it decoded; its end would come over one of `links`."""
        decoded = decode_status_code(code)
        if decoded.known and decoded.level is FaultLevel.NORMAL:
            self._clear(decoded.source)
        elif decoded.is_fault:
            self._active[code] = decoded, links
            self._before.pop(code, None)
        return decoded

    def _clear(self, source: tuple[int, int, int, int]) -> None:
        # Submodule 00 speaks for its whole module (140200000000 "initialisation done" ends the 1402xx
        # failures).
        depth = 4 if source[3] else 3
        self._active = {c: f for c, f in self._active.items() if f[0].source[:depth] != source[:depth]}
        self._before = {c: f for c, f in self._before.items() if f.source[:depth] != source[:depth]}

    def keep_links(self, up: frozenset[object]) -> None:
        """Keep only the faults received over a link in `up` as active.

        The others may be over: their end may have been missed, or the robot was restarted.
        """
        for code, (fault, links) in list(self._active.items()):
            if not links <= up:
                del self._active[code]
                self._before[code] = fault

    def forget_before(self) -> None:
        """Remove the faults that may be over, because the robot reports that it has none."""
        self._before.clear()

    @property
    def before(self) -> tuple[StatusCode, ...]:
        """Faults that may be over."""
        return tuple(self._before.values())

    @property
    def active(self) -> tuple[StatusCode, ...]:
        """Active faults, the worst first, then in order of arrival."""
        return tuple(sorted((fault for fault, _ in self._active.values()), key=lambda fault: -fault.level))
