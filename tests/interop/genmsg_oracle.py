"""Run by Debian's Python: genmsg's word on definitions. Reads a JSON list of cases, writes a list of answers.

A case is {"types": {"pkg/Type": text}, "main": "pkg/Type", "kind": "msg" or "srv"}; the answer is
{"error": text} or {"md5": ..., "full_text": ..., "fields": [[type, name]], "constants": [[type, name, text]]}.
"""

import json
import sys

from genmsg import MsgContext, gentools
from genmsg.msg_loader import load_depends, load_msg_from_string, load_srv_from_string


def answer(case):
    context = MsgContext.create_default()
    main = None
    for name, text in case["types"].items():
        if name == case["main"]:
            load = load_srv_from_string if case["kind"] == "srv" else load_msg_from_string
            main = load(context, text, name)
        else:
            load_msg_from_string(context, text, name)
    load_depends(context, main, {})
    parts = [main] if case["kind"] == "msg" else [main.request, main.response]
    return {
        "md5": gentools.compute_md5(context, main),
        "full_text": [gentools.compute_full_text(context, part) for part in parts],
        "fields": [[list(field) for field in part.fields()] for part in parts],
        "constants": [[[c.type, c.name, c.val_text, repr(c.val)] for c in part.constants] for part in parts],
        "header": [part.has_header() for part in parts],
    }


def main():
    answers = []
    for case in json.load(sys.stdin):
        try:
            answers.append(answer(case))
        except (Exception, RecursionError) as error:
            answers.append({"error": f"{type(error).__name__}: {error}"})
    json.dump(answers, sys.stdout)


if __name__ == "__main__":
    main()
