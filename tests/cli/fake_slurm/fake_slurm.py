#!/usr/bin/env -S python3 -S -E
"""sbatch, squeue and scancel in one, called by these names: jobs are plain processes, kept track of in $FAKE_SLURM_DIR.

What a queue can do is asked for by files there: `refuse` (sbatch fails), `deaf` (squeue fails), `pending` (jobs wait
for the reason in it). `submitted` gets a line for each job, `cancelled` one for each that was cancelled.
"""
import os
import signal
import subprocess
import sys
import time

state = os.environ["FAKE_SLURM_DIR"]


def path(name):
    return os.path.join(state, name)


def text_of(name):
    try:
        with open(path(name)) as file:
            return file.read()
    except FileNotFoundError:
        return None


def append(name, line):
    with open(path(name), "a") as file:
        file.write(line + "\n")


def sbatch(arguments):
    if text_of("refuse") is not None:
        sys.exit("sbatch: error: Batch job submission failed: Invalid partition name specified")
    name = [a.split("=", 1)[1] for a in arguments if a.startswith("--job-name=")][0]
    for number in range(1, 10000):
        try:
            os.close(os.open(path("%d.claimed" % number), os.O_CREAT | os.O_EXCL))
            break
        except FileExistsError:
            pass
    append("submitted", "%d %s" % (number, " ".join(arguments[:-1])))
    pid = 0
    if text_of("pending") is None:
        with open(os.devnull) as null, open(path("%d.out" % number), "w") as out:
            pid = subprocess.Popen([arguments[-1]] if os.access(arguments[-1], os.X_OK) else ["sh", arguments[-1]],
                                   stdin=null, stdout=out, stderr=out, start_new_session=True,
                                   env=dict(os.environ, SLURM_JOB_ID=str(number))).pid
    with open(path("%d.new" % number), "w") as file:
        file.write("%d %d %s" % (pid, time.time(), name))
    os.rename(path("%d.new" % number), path("%d.job" % number))
    print(number)


def is_running(pid):
    try:
        with open("/proc/%d/stat" % pid) as file:
            return file.read().rsplit(")", 1)[1].split()[0] != "Z"
    except OSError:
        return False


def squeue():
    if text_of("deaf") is not None:
        sys.exit("slurm_load_jobs error: Unable to contact slurm controller (connect failure)")
    for file in sorted(os.listdir(state)):
        if not file.endswith(".job"):
            continue
        pid, begin, name = text_of(file).split(" ", 2)
        number = file[:-len(".job")]
        seconds = int(time.time() - int(begin))
        if pid == "0":
            print("%s|PENDING|%s|0:00|%s" % (number, text_of("pending").strip(), name))
        elif is_running(int(pid)):
            print("%s|RUNNING|None|%d:%02d|%s" % (number, seconds // 60, seconds % 60, name))


def scancel(arguments):
    append("cancelled", arguments[-1])
    job = text_of(arguments[-1] + ".job")
    if job is None:
        return
    os.remove(path(arguments[-1] + ".job"))
    pid = int(job.split()[0])
    if pid > 0:
        try:
            os.killpg(pid, signal.SIGKILL)
        except ProcessLookupError:
            pass


called = os.path.basename(sys.argv[0])
if called == "sbatch":
    sbatch(sys.argv[1:])
elif called == "squeue":
    squeue()
else:
    scancel(sys.argv[1:])
