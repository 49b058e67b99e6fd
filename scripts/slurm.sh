#!/bin/bash
# A Slurm of one node for tests, without systemd, as any user: slurm.sh up DIR [CPUS] | down DIR.
# Everything is in DIR; `. DIR/environment` makes sbatch, squeue and scancel talk to it.
# Needs Debian's packages slurm-wlm and munge (scripts/setup.sh slurm).
set -euo pipefail

usage() { echo "usage: slurm.sh up DIR [CPUS] | down DIR" >&2; exit 2; }
[ $# -ge 2 ] || usage
action=$1
mkdir -p "$2"
dir=$(cd "$2" && pwd)
export PATH=$PATH:/usr/sbin:/sbin

free_port() { python3 -c 'import socket; s = socket.socket(); s.bind(("127.0.0.1", 0)); print(s.getsockname()[1])'; }

up() {
    local cpus=${1:-4} user host daemon
    user=$(id -un)
    host=$(hostname -s)
    for daemon in munged slurmctld slurmd; do
        command -v $daemon >/dev/null || { echo "slurm.sh: $daemon is not installed (slurm-wlm, munge)" >&2; exit 1; }
    done
    mkdir -p "$dir"/{munge,state,spool,log}
    chmod 700 "$dir/munge"
    head -c 1024 /dev/urandom >"$dir/munge/key"
    chmod 400 "$dir/munge/key"
    munged --force --key-file="$dir/munge/key" --socket="$dir/munge/socket" --pid-file="$dir/munge/pid" \
        --log-file="$dir/munge/log" --seed-file="$dir/munge/seed"
    # Two partitions: one for everybody, one whose jobs nobody may start (its limit of time is below any request).
    cat >"$dir/slurm.conf" <<CONF
ClusterName=test
SlurmctldHost=$host(127.0.0.1)
SlurmUser=$user
SlurmdUser=$user
SlurmctldPort=$(free_port)
SlurmdPort=$(free_port)
AuthType=auth/munge
AuthInfo=socket=$dir/munge/socket
CredType=cred/munge
StateSaveLocation=$dir/state
SlurmdSpoolDir=$dir/spool
SlurmctldPidFile=$dir/slurmctld.pid
SlurmdPidFile=$dir/slurmd.pid
SlurmctldLogFile=$dir/log/slurmctld
SlurmdLogFile=$dir/log/slurmd
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
MpiDefault=none
SwitchType=switch/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SchedulerType=sched/backfill
SchedulerParameters=batch_sched_delay=0
SlurmdParameters=config_overrides
ReturnToService=2
KillWait=2
MinJobAge=10
NodeName=$host NodeAddr=127.0.0.1 CPUs=$cpus State=UNKNOWN
PartitionName=main Nodes=$host Default=YES MaxTime=INFINITE State=UP
PartitionName=tiny Nodes=$host MaxTime=1 State=UP
CONF
    echo "export SLURM_CONF='$dir/slurm.conf'" >"$dir/environment"
    export SLURM_CONF=$dir/slurm.conf
    slurmctld -i >"$dir/log/start" 2>&1
    slurmd -N "$host" >>"$dir/log/start" 2>&1 || slurmd >>"$dir/log/start" 2>&1
    for _ in $(seq 100); do
        [ "$(sinfo --noheader --partition=main --format=%T 2>/dev/null)" = idle ] && { echo "slurm.sh: up in $dir"; return; }
        sleep 0.1
    done
    echo "slurm.sh: the node did not become idle; see $dir/log" >&2
    tail -n 20 "$dir"/log/* >&2
    down
    exit 1
}

# TERM, then KILL to those that we started, by the numbers that they wrote.
down() {
    local file pid
    if [ -f "$dir/slurm.conf" ]; then
        SLURM_CONF=$dir/slurm.conf timeout 5 scancel --user="$(id -un)" 2>/dev/null || true
        sleep 0.5
    fi
    for file in slurmd.pid slurmctld.pid munge/pid; do
        [ -f "$dir/$file" ] || continue
        pid=$(cat "$dir/$file")
        kill "$pid" 2>/dev/null || continue
        for _ in $(seq 50); do
            kill -0 "$pid" 2>/dev/null || break
            sleep 0.1
        done
        kill -9 "$pid" 2>/dev/null || true
    done
    rm -rf "$dir/munge" "$dir/state" "$dir/spool" "$dir/slurmd.pid" "$dir/slurmctld.pid"
}

case $action in
up) up "${3:-}" ;;
down) down ;;
*) usage ;;
esac
