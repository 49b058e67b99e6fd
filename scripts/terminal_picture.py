#!/usr/bin/python3
"""A picture (SVG) of a terminal while commands run in it (standard library only):

    terminal_picture.py OUT.svg [--columns 100] [--until PATTERN] [--rows 34] -- COMMAND... [-- COMMAND...]...

The commands run one after another in the working directory, on a terminal of their own. The picture is taken when the
regular expression matches a line that the last command has drawn, and that command is then interrupted; without it when
the last command has ended.
"""
import argparse
import fcntl
import html
import os
import pathlib
import pty
import re
import shlex
import signal
import struct
import subprocess
import sys
import termios

NO_BREAK = "\u00a0"  # blanks in a row stay as many in every viewer


class Screen:
    """What a terminal shows of text with carriage returns and `clear to the end of the line`."""

    def __init__(self, columns):
        self.columns, self.lines, self.at, self.rest = columns, [""], 0, ""

    def put(self, text):
        text = self.rest + text
        self.rest = ""
        while text:
            escape = re.match(r"\x1b\[[0-9;?]*[A-Za-z]", text)
            if escape:
                if escape[0].endswith("K"):
                    self.lines[-1] = self.lines[-1][:self.at]
                text = text[escape.end():]
            elif text[0] == "\x1b" and len(text) < 12:
                self.rest = text  # the other half is on its way
                return
            else:
                self.one(text[0])
                text = text[1:]

    def one(self, c):
        if c == "\r":
            self.at = 0
        elif c == "\n":
            self.lines.append("")
            self.at = 0
        elif c >= " ":
            if self.at == self.columns:  # it wraps
                self.lines.append("")
                self.at = 0
            line = self.lines[-1].ljust(self.at)
            self.lines[-1] = line[:self.at] + c + line[self.at + 1:]
            self.at += 1


def run(command, screen, until):
    ours, theirs = pty.openpty()
    fcntl.ioctl(theirs, termios.TIOCSWINSZ, struct.pack("HHHH", 50, screen.columns, 0, 0))
    child = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=theirs, stderr=theirs,
                             env={**os.environ, "TERM": "xterm"}, start_new_session=True)
    os.close(theirs)
    shot = None
    while True:
        try:
            more = os.read(ours, 4096)
        except OSError:  # the other end is closed
            break
        if not more:
            break
        if shot is None:
            screen.put(more.decode(errors="replace"))
            if until and re.search(until, screen.lines[-1]):
                shot = list(screen.lines)
                child.send_signal(signal.SIGINT)
    child.wait()
    os.close(ours)
    return shot


def svg(lines, columns, title):
    wide, high, size, margin, bar = 8.43, 18, 14, 14, 30
    width, height = round(columns * wide + 2 * margin), bar + margin + high * len(lines) + margin // 2
    out = [f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" viewBox="0 0 {width} {height}">',
           f"<title>{html.escape(title)}</title>",
           f'<rect width="{width}" height="{height}" rx="8" fill="#1d2330"/>',
           f'<rect width="{width}" height="{bar}" rx="8" fill="#39414f"/>',
           f'<text x="{width / 2}" y="20" fill="#d8dee9" text-anchor="middle" font-family="sans-serif" font-size="13">'
           f"{html.escape(title)}</text>",
           f'<g font-family="DejaVu Sans Mono, Menlo, Consolas, monospace" font-size="{size}" fill="#e6e9ef">']
    for row, line in enumerate(lines):
        if not line.strip():
            continue
        colour = ' fill="#9fd3a8"' if line.startswith("$ ") else ' fill="#8ec5ff"' if line.startswith("[") else ""
        words = html.escape(line.replace(" ", NO_BREAK))
        out.append(f'<text x="{margin}" y="{bar + margin + high * row + 6}" textLength="{len(line) * wide:.1f}"'
                   f' lengthAdjust="spacingAndGlyphs"{colour}>{words}</text>')
    return "\n".join(out + ["</g>", "</svg>", ""])


def main():
    parts, rest = [], sys.argv[1:]
    while "--" in rest:
        at = rest.index("--")
        parts.append(rest[:at])
        rest = rest[at + 1:]
    parts.append(rest)
    options, commands = parts[0], parts[1:]
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("out", type=pathlib.Path)
    parser.add_argument("--columns", type=int, default=100)
    parser.add_argument("--rows", type=int, default=34, help="the last so many lines are shown")
    parser.add_argument("--until", default="")
    parser.add_argument("--title", default="strake")
    wanted = parser.parse_args(options)
    if not commands:
        parser.error("no command; write it behind --")
    screen = Screen(wanted.columns)
    shot = None
    for k, command in enumerate(commands):
        screen.put("$ " + shlex.join([pathlib.Path(command[0]).name, *command[1:]]) + "\n")
        shot = run(command, screen, wanted.until if k + 1 == len(commands) else "")
    if wanted.until and shot is None:
        sys.exit("terminal_picture.py: no line matched; the last ones:\n" + "\n".join(screen.lines[-8:]))
    lines = shot or screen.lines
    while lines and not lines[-1].strip():
        lines.pop()
    wanted.out.write_text(svg(lines[-wanted.rows:], wanted.columns, wanted.title))
    print(wanted.out)


main()
