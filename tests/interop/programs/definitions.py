"""genmsg: definitions read, their md5sums and full texts, as tools that generate something use it."""

import os
import sys
import tempfile

import genmsg
import genmsg.gentools
import genmsg.msg_loader
import genmsg.msgs
import genmsg.names
from genmsg import EXT_MSG, InvalidMsgSpec, MsgContext, MsgNotFound
from genmsg.gentools import compute_full_text, compute_md5, compute_md5_text

folder = tempfile.mkdtemp()
TEXTS = {
    "shop_msgs/Item.msg": "# an item\nuint8 SMALL=1\nstring NAME = a # b\nuint8 size\nHeader header\nfloat64[3] at\n",
    "shop_msgs/Cart.msg": "Header header\nItem[] items\nItem gift\ntime at\nshop_msgs/Item[2] two\nother_msgs/Thing thing",
    "other_msgs/Thing.msg": "duration d\nbool[] flags\n",
    "shop_msgs/Buy.srv": "Item item\nint32 A=-3\n---\nbool ok\nstring text\n",
    "shop_msgs/Nothing.srv": "---\n",
    "std_msgs/Header.msg": "uint32 seq\ntime stamp\nstring frame_id\n",
}
for name, text in TEXTS.items():
    path = os.path.join(folder, *name.split("/"))
    os.makedirs(os.path.dirname(path), exist_ok=True)
    with open(path, "w") as file:
        file.write(text)
search = {package: [os.path.join(folder, package)] for package in ("shop_msgs", "other_msgs", "std_msgs")}


def attempt(call, *arguments):
    """Its result, or the kind of its error."""
    try:
        return call(*arguments)
    except Exception as error:
        return type(error).__name__


context = MsgContext.create_default()
print(context.is_registered("time"), context.get_registered("duration").fields())
cart = genmsg.load_msg_by_type(context, "shop_msgs/Cart", search)
print(genmsg.load_depends(context, cart, search))
print(
    cart.fields(),
    cart.has_header(),
    cart.package,
    cart.short_name,
    cart.full_name,
    repr(cart),
    str(cart) == cart.text,
)
for field in cart.parsed_fields():
    print(
        field, field.name, field.base_type, field.is_array, field.array_len, field.is_builtin, field.is_header
    )
item = context.get_registered("shop_msgs/Item[]")
print(
    [(c.type, c.name, c.val, c.val_text) for c in item.constants],
    repr(item.constants[0]),
    repr(item),
    item.has_header(),
)
print(compute_md5(context, cart), compute_md5(context, item), compute_md5_text(context, item))
print(compute_full_text(context, cart))
print(
    context.get_depends("shop_msgs/Cart"),
    context.get_all_depends("shop_msgs/Cart"),
    context.get_depends("x/Y"),
)
print(os.path.relpath(context.get_file("shop_msgs/Item"), folder), context.get_file("x/Y"))
for name in ("Buy", "Nothing"):
    service = genmsg.load_srv_by_type(context, "shop_msgs/" + name, search)
    print(genmsg.load_depends(context, service, search), compute_md5(context, service), repr(service))
    print(repr(service.request.text), repr(service.response.text), service.request.full_name, service.package)
    print(service == genmsg.msg_loader.load_srv_from_string(MsgContext(), service.text, service.full_name))
inline = genmsg.msg_loader.load_msg_from_string(context, "int32 x\nPoint p\n", "mine/Two")
print(
    inline.fields(),
    inline == genmsg.msg_loader.load_msg_from_string(context, "int32 x\nPoint p\n", "mine/Two"),
)
print(attempt(compute_md5, context, inline), attempt(genmsg.load_depends, context, "text", search))
for text in ("int32", "int32 x\nint32 x", "int32 A=b", "float32[x] y", "int32 9x", "int32 x y z"):
    print(attempt(genmsg.msg_loader.load_msg_from_string, MsgContext(), text, "a/B"))
for kind in ("shop_msgs/None", "unknown_pkg/X"):
    try:
        genmsg.load_msg_by_type(context, kind, search)
    except MsgNotFound as error:
        print(error.base_type, error.package, str(error).split(" with ")[0].split(" on ")[0])
print(attempt(genmsg.load_msg_by_type, context, "a/B", None), issubclass(InvalidMsgSpec, Exception), EXT_MSG)
msgs, names = genmsg.msgs, genmsg.names
for kind in (
    "int32",
    "int32[]",
    "Header",
    "std_msgs/Header",
    "a/B[4]",
    "X",
    "a//B",
    "",
    "a[b]",
    "a[][]",
    "9a",
    " a",
    "a[1][2]",
):
    print(kind, [attempt(f, kind) for f in (msgs.bare_msg_type, msgs.parse_type, msgs.is_valid_msg_type,
          msgs.is_valid_constant_type, msgs.is_valid_msg_field_name, msgs.is_builtin, msgs.is_header_type,
          names.resource_name_base, names.resource_name_package, names.package_resource_name,
          names.is_legal_resource_name, names.is_legal_resource_base_name)],
          attempt(msgs.resolve_type, kind, "pkg"), attempt(names.resource_name, "pkg", kind, "pkg"))  # fmt: skip
print([attempt(genmsg.gentools.compute_full_type_name, "p", name) for name in ("A.msg", "B.srv", "C.txt")])
sys.stdout.flush()
