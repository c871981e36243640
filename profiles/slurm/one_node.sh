#!/usr/bin/env bash
# A Slurm of one node on this machine, for trying the profile: no systemd, no accounting database. Needs root, and of
# Debian 12 the packages munge, slurm-client, slurmctld and slurmd.
# Usage: one_node.sh start | stop
set -euo pipefail

home=/var/tmp/lsvib-slurm # state and logs; removed by stop, as is what is written to $etc
etc=/etc/slurm            # the default place: Snakemake's plugin drops SLURM_CONF on the way into a job

start_daemons() {
    if [ -e "$home" ] || [ -e "$etc/slurm.conf" ]; then
        echo "$home or $etc/slurm.conf exists: this machine has a Slurm, or one that was started here and not stopped." >&2
        exit 1
    fi
    mkdir -p "$home/state" "$home/spool"
    # The hardware as slurmd sees it; its second line is the time since boot. Processes are followed by their parents
    # (linuxproc), so neither cgroups nor systemd are needed, and limits on memory are requests that nobody enforces.
    # MinJobAge keeps finished jobs visible to squeue, which Snakemake asks.
    cat >"$etc/slurm.conf" <<CONF
ClusterName=lsvib
SlurmctldHost=$(hostname -s)
SlurmUser=root
AuthType=auth/munge
AuthInfo=socket=$home/munge.socket
CredType=cred/munge
StateSaveLocation=$home/state
SlurmdSpoolDir=$home/spool
SlurmctldPidFile=$home/slurmctld.pid
SlurmdPidFile=$home/slurmd.pid
SlurmctldLogFile=$home/slurmctld.log
SlurmdLogFile=$home/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/linux
AccountingStorageType=accounting_storage/none
JobCompType=jobcomp/filetxt
JobCompLoc=$home/completed_jobs.txt
MpiDefault=none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core_Memory
DefMemPerCPU=1000
MinJobAge=600
ReturnToService=2
$(slurmd -C | grep '^NodeName=') State=UNKNOWN
PartitionName=main Nodes=$(hostname -s) Default=YES MaxTime=INFINITE State=UP
CONF
    echo "CgroupPlugin=cgroup/v1" >"$etc/cgroup.conf" # nothing here uses cgroups, but slurmd insists on a plugin
    (umask 077 && head -c 128 /dev/urandom >"$home/munge.key")
    # --force: munge dislikes a key and a socket below a folder that all may write to, as /var/tmp is.
    munged --force --socket="$home/munge.socket" --key-file="$home/munge.key" --pid-file="$home/munged.pid" \
        --log-file="$home/munged.log" --seed-file="$home/munged.seed"
    slurmctld
    slurmd
    for _ in $(seq 30); do
        sinfo --noheader --format=%T 2>/dev/null | grep -qx idle && echo "Slurm is up." && return
        sleep 1
    done
    echo "Slurm did not come up within 30 s; see the logs in $home." >&2
    exit 1
}

stop_daemons() {
    [ -e "$home" ] || { echo "No Slurm was started here." >&2 && exit 1; }
    for daemon in slurmd slurmctld munged; do
        pid=$(cat "$home/$daemon.pid" 2>/dev/null) || continue
        kill "$pid" || true
        while kill -0 "$pid" 2>/dev/null; do sleep 0.2; done
    done
    rm -rf "$home"
    rm -f "$etc/slurm.conf" "$etc/cgroup.conf"
}

case "${1:-}" in
    start) start_daemons ;;
    stop) stop_daemons ;;
    *) echo "usage: $0 start | stop" >&2 && exit 2 ;;
esac
