"""rosunit: runs unittest cases as ROS does, with a summary on stdout, a JUnit file, exit code 1 for failures.

`--gtest_output=xml:FILE` sets the file; the default is PACKAGE/rosunit-NAME.xml in $ROS_TEST_RESULTS_DIR or
~/.ros/test_results. `--text` prints unittest's report instead of writing the file.
"""

import os
import sys
import time
import traceback
import unittest
from contextlib import redirect_stderr, redirect_stdout
from io import StringIO

XML_OUTPUT_FLAG = "--gtest_output=xml:"


def unitrun(package, test_name, test, sysargs=None, coverage_packages=None):
    """Run a TestCase class, or tests by name; end the process with exit code 1 on a failure."""
    if not run(package, test_name, test, sys.argv if sysargs is None else sysargs).wasSuccessful():
        sys.exit(1)


def run(package, test_name, test, words):
    """Run the tests with the options in `words` and print the summary; return the unittest result."""
    loader = unittest.TestLoader()
    named = isinstance(test, str)
    suite = loader.loadTestsFromName(test) if named else loader.loadTestsFromTestCase(test)
    files = [word[len(XML_OUTPUT_FLAG) :] for word in words if word.startswith(XML_OUTPUT_FLAG)]
    if "--text" in words:
        runner = unittest.TextTestRunner(verbosity=2)
    else:
        runner = create_xml_runner(package, test_name, files[-1] if files else None)
    result = runner.run(suite)
    print_unittest_summary(result)
    return result


def xml_results_file(test_pkg, test_name, is_rostest=False, env=None):
    """Path of a test's result file; creates its folder."""
    env = os.environ if env is None else env
    home = env.get("ROS_HOME") or os.path.join(os.path.expanduser("~"), ".ros")
    folder = os.path.join(env.get("ROS_TEST_RESULTS_DIR") or os.path.join(home, "test_results"), test_pkg)
    os.makedirs(folder, exist_ok=True)
    plain = "".join("_" if letter in " \"'&$!`/\\" else letter for letter in test_name)
    return os.path.join(folder, "%s-%s.xml" % ("rostest" if is_rostest else "rosunit", plain))


def create_xml_runner(test_pkg, test_name, results_file=None, is_rostest=False):
    """Return a test runner that writes a JUnit file."""
    file = results_file or xml_results_file(test_pkg, os.path.basename(test_name), is_rostest)
    os.makedirs(os.path.dirname(os.path.abspath(file)), exist_ok=True)
    print("[ROSUNIT] Outputting test results to " + file)
    return _XmlRunner(file)


class _Result(unittest.TestResult):
    """Records the duration and the errors of each test."""

    def __init__(self):
        super().__init__()
        self.rows = []

    def startTest(self, test):
        super().startTest(test)
        self._began = time.monotonic()
        self._wrong = None

    def addError(self, test, err):
        super().addError(test, err)
        self._wrong = "error", err

    def addFailure(self, test, err):
        super().addFailure(test, err)
        self._wrong = "failure", err

    def stopTest(self, test):
        super().stopTest(test)
        self.rows.append((test.id(), time.monotonic() - self._began, self._wrong))


class _XmlRunner:
    def __init__(self, file):
        self._file = file

    def run(self, test):
        """Run the tests; the file includes their output."""
        result, out, err, began = _Result(), StringIO(), StringIO(), time.monotonic()
        with redirect_stdout(out), redirect_stderr(err):
            test(result)
        self._write(test, result, time.monotonic() - began, out.getvalue(), err.getvalue())
        for name, _, wrong in result.rows:
            _report(name.rpartition(".")[2], wrong)
        return result

    def _write(self, test, result, seconds, out, err):
        from xml.etree import ElementTree

        kind = type(test)
        suite = ElementTree.Element("testsuite", name="%s.%s" % (kind.__module__, kind.__name__))
        counts = {"errors": len(result.errors), "failures": len(result.failures), "tests": result.testsRun}
        suite.attrib.update({what: str(count) for what, count in counts.items()}, time="%.3f" % seconds)
        for name, took, wrong in result.rows:
            cls, _, method = name.rpartition(".")
            case = ElementTree.SubElement(suite, "testcase", classname=cls, name=method, time="%.4f" % took)
            if wrong is not None:
                what, (error_type, error, trace) = wrong
                tag = ElementTree.SubElement(case, what, type=error_type.__name__)
                tag.text = _printable("%s\n%s" % (error, "".join(traceback.format_tb(trace))))
        for tag, text in (("system-out", out), ("system-err", err)):
            ElementTree.SubElement(suite, tag).text = "<![CDATA[\n%s\n]]>" % _printable(text)
        ElementTree.ElementTree(suite).write(self._file, "utf-8", xml_declaration=True)


def _printable(text):
    """Escape characters that XML does not allow."""
    return "".join(c if c.isprintable() or c in "\t\n\r" else "&#x%04X;" % ord(c) for c in text)


def _report(method, wrong):
    from xml.sax.saxutils import escape

    print("[Testcase: %s] ... %s" % (method, {None: "ok"}.get(wrong) or wrong[0].upper() + "!"))
    if wrong is not None:
        what, (_, error, trace) = wrong
        print("%s: %s" % (what.upper(), escape(str(error))))
        print(escape("".join(traceback.format_tb(trace))), end="")
        print("-" * 80)


def print_unittest_summary(result):
    """Print the number of tests and the failed ones."""

    def named(rows):
        names = [getattr(test, "_testMethodName", None) or "%s: %s\n" % (test, text) for test, text in rows]
        return "%s [%s]" % (len(rows), ", ".join(names))

    good = result.wasSuccessful()
    print("-" * 61 + "\nSUMMARY:")
    print("\033[32m * RESULT: SUCCESS\033[0m" if good else " * RESULT: FAIL")
    print(" * TESTS: %s" % result.testsRun)
    print(" * ERRORS: %s\n * FAILURES: %s\n" % (named(result.errors), named(result.failures)))
