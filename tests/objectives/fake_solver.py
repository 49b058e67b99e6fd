#!/usr/bin/env python3
"""A solver that misbehaves on demand: fake_solver.py ROLE REQUEST RESULT, in the evaluation's folder.

The right answer is the sum of all coordinates, whose gradient is one everywhere.
"""
import json
import os
import signal
import subprocess
import sys
import time

role, request_file, result_file = sys.argv[1:4]
with open(request_file) as file:
    request = json.load(file)
surface = request["surface"]


def vertices():
    with open(surface) as lines:
        return [tuple(float(x) for x in line.split()[1:4]) for line in lines if line.startswith("v ")]


def gradient_rows(by="index"):
    if by == "index":
        return [f"{k},1,1,1" for k, _ in enumerate(vertices())]
    return [f"{x!r},{y!r},{z!r},1,1,1" for x, y, z in reversed(vertices())]


def write_gradient(rows, name="gradient.csv"):
    with open(name, "w") as file:
        file.write("\n".join(rows) + "\n")


def write_text(text):
    with open(result_file, "w") as file:
        file.write(text)


def write_result(**more):
    value = 0.0
    for x, y, z in vertices():
        value += x + y + z
    write_text(json.dumps({"value": value, "gradient": "gradient.csv", **more}))


def ok():
    write_gradient(gradient_rows())
    write_result()


def coordinates():
    write_gradient(["x,y,z,dJ/dx,dJ/dy,dJ/dz"] + gradient_rows("place"))
    write_result()


def two_values():
    write_gradient(["# comment", "", "index , a, b, c"] + gradient_rows(), "drag.csv")
    write_gradient([row.replace(",1,1,1", ", 2.0D0, +2, 2e0") for row in gradient_rows()], "lift.csv")
    write_text(json.dumps({"values": {"drag": 1.5, "lift": -0.5, "moment": 7},
                           "gradients": {"drag": "drag.csv", "lift": "lift.csv"},
                           "variables": {"drag": {"alpha": 0.1}}, "info": {"residual": "1e-9"}}))


def by_variables(derivatives):
    """The right answer plus twice alpha."""
    def play():
        write_gradient(gradient_rows())
        total = sum(x + y + z for x, y, z in vertices()) + 2 * request["variables"]["alpha"]
        write_text(json.dumps({"value": total, "gradient": "gradient.csv", "variables": derivatives}))
    return play


def values_only():
    assert request["wanted"]["gradients"] == []
    write_text(json.dumps({"value": sum(x + y + z for x, y, z in vertices())}))


def gradients():
    """What a gradient command writes."""
    assert request["wanted"]["gradients"] == ["value"]
    write_gradient(gradient_rows(), "separate.csv")
    write_text(json.dumps({"gradient": "separate.csv"}))


def flaky_gradients():
    if not os.path.exists("tried"):
        open("tried", "w").close()
        sys.exit(4)
    gradients()


def at_points():
    """The sum of the coordinates of the points that move with the surface."""
    with open(request["points"]) as lines:
        rows = [line.strip().split(",") for line in lines][1:]
    numbered = [row if len(row) == 4 else [str(k)] + row for k, row in enumerate(rows)]
    write_gradient(["PointID,x,y,z,Sensitivity_x,Sensitivity_y,Sensitivity_z"] +
                   [",".join(row + ["1", "1", "1"]) for row in reversed(numbered)])
    write_text(json.dumps({"value": sum(float(x) for row in numbered for x in row[1:]), "gradient": "gradient.csv"}))


def environment():
    """What the program was started with, for the test to look at."""
    seen = {"cwd": os.getcwd(), "stdin": os.readlink("/proc/self/fd/0"), "descriptors": sorted(
        fd for fd in os.listdir("/proc/self/fd") if int(fd) > 2 and os.path.exists(f"/proc/self/fd/{fd}")),
        "leads_group": os.getpgid(0) == os.getpid(), "leads_session": os.getsid(0) == os.getpid(),
        "pipe_signal": signal.getsignal(signal.SIGPIPE) == signal.SIG_IGN, "request": request}
    with open("seen.json", "w") as file:
        json.dump(seen, file)
    ok()


def exit_3():
    print("\x1b[31mdiverged\x1b[0m at step 17\x07", file=sys.stderr)
    sys.exit(3)


def exit_1_with_result():
    ok()
    sys.exit(1)


def die():
    os.kill(os.getpid(), signal.SIGSEGV)


def leave_grandchild(extra=""):
    child = subprocess.Popen([sys.executable, "-c", f"import os, signal, time\n{extra}\n"
                              "open('grandchild.pid.new', 'w').write(str(os.getpid()))\n"
                              "os.rename('grandchild.pid.new', 'grandchild.pid')\ntime.sleep(60)"])
    while not os.path.exists("grandchild.pid"):
        time.sleep(0.01)
    return child


def hang():
    leave_grandchild()
    print("still running", flush=True)
    time.sleep(60)


def ignore_term():
    signal.signal(signal.SIGTERM, signal.SIG_IGN)
    leave_grandchild("signal.signal(signal.SIGTERM, signal.SIG_IGN)")
    time.sleep(60)


def spin():
    print("iteration 17", flush=True)
    while True:
        pass


def late():
    """Ends well; a process that has left its group writes the result afterwards."""
    leave_grandchild("os.setsid()\nfor fd in range(3): os.close(fd)\nif os.fork() == 0:\n"
                     "    time.sleep(1.5)\n    open('result.json', 'w').write('{\"value\": 1}')\n    os._exit(0)")


def twice():
    write_text('{"value": 1, "gradient": "gradient.csv"}')
    ok()


def flaky():
    """Fails twice, then never again: the count lies beside the folders of the evaluations."""
    with open("../../flaky", "a+") as file:
        file.write("x")
        count = file.tell()
    if count < 3:
        print("no licence", count, file=sys.stderr)
        sys.exit(3)
    ok()


def flood_and_hang():
    block = b"y" * 99 + b"\n"
    while True:
        sys.stdout.buffer.write(block * 1000)


def close_outputs_and_hang():
    for fd in range(3):
        os.close(fd)
    time.sleep(60)


def stop_itself():
    os.kill(os.getpid(), signal.SIGSTOP)


def daemon_holds_pipe():
    leave_grandchild("os.setsid()")
    ok()


def leftover():
    leave_grandchild()
    ok()


def flood():
    block = b"x" * 99 + b"\n"
    for stream in (sys.stdout, sys.stderr):
        for _ in range(250):
            stream.buffer.write(block * 1000)
    stream.buffer.write(b"the last line\n")
    ok()


def deletes_surface():
    ok()
    os.remove(surface)
    os.remove(request_file)


def damages_surface():
    ok()
    write_text_to = open(surface, "w")
    write_text_to.write("garbage")


def deletes_folder():
    for name in os.listdir("."):
        os.remove(name)
    os.rmdir(os.getcwd())


def link_result():
    with open("elsewhere.json", "w") as file:
        file.write('{"value": 1}')
    os.symlink("elsewhere.json", result_file)


def wrong_gradient(change):
    def play():
        write_gradient(change(gradient_rows()))
        write_result()
    return play


ROLES = {
    "by_alpha": by_variables({"value": {"alpha": 2.0, "speed": -1, "unknown": 3}}),
    "by_alpha_short": by_variables({"alpha": 2.0, "speed": -1}),
    "by_alpha_only": by_variables({"alpha": 2.0}),
    "by_alhpa": by_variables({"alhpa": 2.0, "speed": -1}),
    "by_other_value": by_variables({"drag": {"alpha": 2.0, "speed": -1}}),
    "by_word": by_variables({"value": {"alpha": "x", "speed": 1}}),
    "no_result": lambda: print("nothing to say"),
    "empty": lambda: write_text(""),
    "truncated": lambda: write_text('{\n  "value": 1.0,\n  "grad'),
    "nan_literal": lambda: write_text('{"value": NaN}'),
    "minus_infinity": lambda: write_text('{"value":\n -Infinity}'),
    "overflow": lambda: write_text('{"value": 1e400}'),
    "string": lambda: write_text('{"value": "1.0"}'),
    "array": lambda: write_text("[1.0]"),
    "deep": lambda: write_text('{"value": ' + "[" * 1000000 + "]" * 1000000 + "}"),
    "missing_key": lambda: write_text('{"valeu": 1.0}'),
    "key_twice": lambda: write_text('{"value": 1.0, "value": 2.0}'),
    "both_forms": lambda: write_text('{"value": 1.0, "values": {"value": 1.0}}'),
    "no_gradient": lambda: write_text('{"value": 1.0}'),
    "bad_variables": lambda: write_text('{"value": 1.0, "variables": {"drag": {"alpha": "x"}}}'),
    "utf16": lambda: open(result_file, "wb").write('{"value": 1}'.encode("utf-16")),
    "binary": lambda: open(result_file, "wb").write(b'{"value": \x00}'),
    "huge": lambda: open(result_file, "wb").truncate(1 << 40),
    "directory": lambda: os.mkdir(result_file),
    "fifo": lambda: os.mkfifo(result_file),
    "link": link_result,
    "gradient_short": wrong_gradient(lambda rows: rows[:-1]),
    "gradient_twice": wrong_gradient(lambda rows: rows + rows[:1]),
    "gradient_nan": wrong_gradient(lambda rows: rows[:2] + ["2,1,nan,1"] + rows[3:]),
    "gradient_columns": wrong_gradient(lambda rows: rows[:2] + ["2,1,1"] + rows[3:]),
    "gradient_word": wrong_gradient(lambda rows: rows[:2] + ["2,1,one,1"] + rows[3:]),
    "gradient_index": wrong_gradient(lambda rows: rows[:-1] + [f"{len(rows)},1,1,1"]),
    "gradient_far": wrong_gradient(lambda rows: [f"{x!r},{y!r},{z + 0.01!r},1,1,1" for x, y, z in vertices()]),
    "gradient_missing": lambda: write_result(),
    "gradient_outside": lambda: write_result(gradient="../../etc/passwd"),
    "gradient_absolute": lambda: write_result(gradient="/etc/passwd"),
    "gradient_number": lambda: write_result(gradient=3),
}
(ROLES.get(role) or globals()[role])()
