"""genmsg as far as programs import it: definitions as MsgSpec and SrvSpec, their md5sums and full texts.

Templates and generators for other languages are not here. Types that a search path does not name are taken
from the definitions of this program (the bundled ones and those of --msg-path).
"""

from . import base, gentools, msg_loader, msgs, names, srvs
from .base import EXT_MSG, EXT_SRV, MSG_DIR, SEP, SRV_DIR, InvalidMsgSpec, MsgGenerationException
from .gentools import compute_full_text, compute_md5, compute_md5_text
from .msg_loader import MsgContext, MsgNotFound, load_depends, load_msg_by_type, load_srv_by_type
from .msgs import DURATION, HEADER, TIME, Constant, Field, MsgSpec
from .names import (
    is_legal_resource_base_name,
    is_legal_resource_name,
    package_resource_name,
    resource_name,
    resource_name_base,
    resource_name_package,
)
from .srvs import SrvSpec
