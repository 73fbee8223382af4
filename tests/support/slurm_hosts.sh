# A Slurm cluster of the hosts a and b of two_hosts.sh, for this test alone. Source it after two_hosts.sh; $reach are the
# words that start a program on a host. Ends the calling test as skipped (77) where there is none.
for tool in slurmctld slurmd srun sinfo munged; do
    command -v "$tool" >/dev/null || skip "$tool is not installed (slurmctld, slurmd, slurm-client, munge)"
done
slurm_folder=$work-slurm
trap 'clean_up; rm -rf "$slurm_folder"' EXIT
mkdir -m 755 "$slurm_folder" && mkdir "$slurm_folder/state" "$slurm_folder/host-a" "$slurm_folder/host-b"
(umask 077 && head -c 1024 /dev/urandom >"$slurm_folder/munge.key")
export SLURM_CONF=$slurm_folder/slurm.conf
cat >"$SLURM_CONF" <<EOT
ClusterName=test
SlurmctldHost=host-a
SlurmUser=root
MpiDefault=none
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
ReturnToService=2
SlurmctldPidFile=/run/slurmctld.pid
SlurmdPidFile=/run/slurmd.pid
StateSaveLocation=$slurm_folder/state
SlurmdSpoolDir=$slurm_folder/%n
SlurmctldLogFile=$slurm_folder/slurmctld
SlurmdLogFile=$slurm_folder/%n/log
NodeName=host-a CPUs=2
NodeName=host-b CPUs=2
PartitionName=all Nodes=ALL Default=YES
EOT
echo "CgroupPlugin=cgroup/v1" >"$slurm_folder/cgroup.conf" # looked for, but with linuxproc not used
for side in a b; do
    "on_$side" mkdir /run/munge
    "on_$side" munged --key-file="$slurm_folder/munge.key" --pid-file=/run/munge/pid --force \
        --log-file=/run/munge/log --seed-file=/run/munge/seed 2>"$work/why" || skip "no munged: $(cat "$work/why")"
done
on_a slurmctld 2>"$work/why" || skip "no slurmctld: $(cat "$work/why")"
for side in a b; do "on_$side" slurmd -N "host-$side" 2>"$work/why" || skip "no slurmd: $(cat "$work/why")"; done
for _ in $(seq 200); do
    [ "$(on_a sinfo -h -o %t 2>/dev/null)" = idle ] && break
    sleep 0.1
done
on_a timeout 20 srun -Q -N1 -n1 -w host-b true 2>"$work/why" || skip "no srun: $(cat "$work/why")"
reach="srun, -Q, -N1, -n1, -w"
reach_tool=srun
