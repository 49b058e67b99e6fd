"""Help, completions and the man page hold every command and option. Argument: the program."""
import json
import re
import shutil
import subprocess
import sys
import tempfile
import time

STRAKE = sys.argv[1]
failures = []


def expect(is_so, words):
    if not is_so:
        failures.append(words)


def said(*arguments, status=0):
    done = subprocess.run([STRAKE, *arguments], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    expect(done.returncode == status, "%s: status %d" % (arguments, done.returncode))
    return done


def completed(script, *words):
    """What bash offers for the last word."""
    line = "source %s; COMP_WORDS=(%s); COMP_CWORD=%d; _strake; echo ${COMPREPLY[@]}" % (
        script, " ".join("'%s'" % w for w in words), len(words) - 1)
    return subprocess.run(["bash", "-c", line], stdout=subprocess.PIPE, text=True).stdout.split()


help_text = said("--help").stdout
commands = re.findall(r"^  ([a-z-]+) {2,}", help_text.split("Subcommands:")[1].split("Exit statuses")[0], re.M)
expect(len(commands) >= 18, "commands: %s" % commands)
for status in ("0", "1", "2", "3", "4", "5", "75"):
    expect(re.search(r"^  %s +\w" % status, help_text.split("Exit statuses")[1], re.M), "exit status %s in --help" % status)
scripts = {shell: said("completion", shell).stdout for shell in ("bash", "zsh", "fish")}
manual = said("man").stdout
slowest = 0.0
for command in commands:
    begin = time.monotonic()
    text = said(command, "--help").stdout
    slowest = max(slowest, time.monotonic() - begin)
    expect(".SS %s\n" % command.replace("-", r"\-") in manual, "%s in the man page" % command)
    for option in set(re.findall(r"(?<![\w-])--[a-z][a-z-]+", re.sub(r"^.*?Options:", "", text, flags=re.S))):
        if not re.search(r"^  [^ ].*%s\b" % option, text, re.M):
            continue  # only mentioned
        for shell, form in (("bash", option), ("zsh", option + "["), ("fish", "-l " + option[2:])):
            expect(form in scripts[shell], "%s %s is not completed in %s" % (command, option, shell))
        expect(option.replace("-", r"\-") in manual, "%s %s in the man page" % (command, option))
expect(slowest < 1, "--help takes %.2f s" % slowest)  # 50 ms are promised; machines that test are busy

nothing = said(status=2)
expect("Usage:" in nothing.stderr and not nothing.stdout, "without arguments: %r" % nothing.stderr)
expect(re.match(r"strake \d+\.\d+", said("--version").stdout), "--version")
licenses = said("--licenses").stdout
expect("Apache-2.0" in licenses, "--licenses: " + licenses)
if "no part under the GPL" in licenses:  # built with -DSTRAKE_GPL=OFF
    expect(not re.search(r"CHOLMOD|SPQR|alpha wrap|\bGPL-(?!\S+ WITH GCC-exception)", licenses), "--licenses: " + licenses)
else:
    expect("CHOLMOD" in licenses and re.search(r"\bGPL-", licenses) and "GPL, version 3" in licenses, "--licenses: " + licenses)

with tempfile.NamedTemporaryFile("w", suffix=".bash") as script:
    script.write(scripts["bash"])
    script.flush()
    expect("check" in completed(script.name, "strake", "ch"), "bash: commands")
    expect("--evaluate" in completed(script.name, "strake", "check", "--ev"), "bash: options")
    expect(completed(script.name, "strake", "explain", "optimize.me") == ["optimize.method"], "bash: keys")
    expect("wave_drag" in completed(script.name, "strake", "explain", "wave"), "bash: types of quantities")
    expect(completed(script.name, "strake", "run", "--set", "optimize.budget.ev") == ["optimize.budget.evaluations="], "bash: --set")
    expect(completed(script.name, "strake", "completion", "") == ["bash", "zsh", "fish"], "bash: words")
for shell in ("zsh", "fish"):  # their own parsers, where they are installed
    if shutil.which(shell):
        expect(subprocess.run([shell, "-n"], input=scripts[shell], text=True).returncode == 0, "%s: syntax" % shell)
if shutil.which("man"):
    page = subprocess.run(["man", "--warnings", "-l", "-"], input=manual, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    expect(page.returncode == 0 and not page.stderr, "man: %s" % page.stderr)

keys = [row["key"] for row in json.loads(said("explain", "--json").stdout)]
expect("optimize.method" in keys and len(keys) > 150, "keys: %d" % len(keys))
for wanted, has in (("optimize.method", "default  auto"), ("regions.tip.box", "Two opposite corners"),
                    ("loads[0].region", "the key is required"), ("budget.evaluations", "optimize.budget.evaluations"),
                    ("cobyla", "is a value of optimize.method"), ("repair.holes", "all"),
                    ("wave_drag", "stations        Number of interior sections. [40]"), ("friction", "reynolds"),
                    ("newtonian", "drag, lift, side"), ("thickness", "a type of quantities")):
    expect(has in said("explain", wanted).stdout, "explain %s: %s" % (wanted, said("explain", wanted).stdout))
types = json.loads(said("explain", "quantities.*.type", "--json").stdout)[0]["forms"][0]["form"].split(", ")
expect(len(types) > 20, "types: %s" % types)
for kind in types:
    told = [row for row in json.loads(said("explain", kind, "--json").stdout) if "meaning" in row]
    expect(len(told) == 1 and told[0]["value_of"] == ["quantities.*.type"], "explain %s: %s" % (kind, told))
expect(all(len(line) < 200 for line in said("explain").stdout.splitlines()), "explain: long lines")
print("\n".join(failures) or "%d commands, %d keys" % (len(commands), len(keys)))
sys.exit(1 if failures else 0)
