"""Fields and constants whose names Python reserves: genpy puts an underscore behind them, everywhere."""

import copy
import io
import pickle

import genpy
from my_msgs.msg import Odd, OddHolder
from woosh_msgs.msg import NavMode

print(Odd.__slots__, Odd._slot_types, Odd.pass_, Odd.OTHER)
odd = Odd()
for name in ("yield_", "in_", "from_", "class_", "self_", "print", "print_", "lambda_", "None_"):
    print(name, hasattr(odd, name))
odd.yield_, odd.in_, odd.from_, odd.class_, odd.lambda_ = 3, 4, "x", [1.0], b"ab"
print(odd)
print(repr(odd))
print(Odd(yield_=5).yield_, Odd(*range(2), "x", [], 4, 5, b"", 6, "y").in_)
try:
    Odd(nothing_=1)
except AttributeError as error:
    print(error)
holder = OddHolder(def_=odd, with_=[odd])
print(holder, holder.__slots__)
buffer = io.BytesIO()
holder.serialize(buffer)
print(buffer.getvalue().hex(), OddHolder().deserialize(buffer.getvalue()) == holder)
print(copy.deepcopy(holder) == holder, pickle.loads(pickle.dumps(holder)) == holder)
print(
    genpy.message.strify_message(
        holder, field_filter=lambda one: [n for n in one.__slots__ if n != "lambda_"]
    )
)
print(genpy.message.get_printable_message_args(holder))
for arguments in ([{"def": {"yield": 1}}], [{"def_": {"yield_": 1}}]):
    holder = OddHolder()
    try:
        genpy.message.fill_message_args(holder, arguments)
        print(holder.def_.yield_)
    except genpy.MessageException as error:
        print(error)
print(NavMode().__slots__, NavMode())
