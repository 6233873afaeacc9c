#!/usr/bin/env bash
# farm_test.sh slurm|parallel|ssh PROGRAM FOLDER: a recording in 8 shards on a farm of this machine alone,
# of which a node is killed in the middle of a shard and another shard fails the first time. The
# merge must find all, the clouds be those of one run, and no scan be done twice but those that were
# lost. Exit code 77: skipped, for lack of what is said.
#
# WINDOWS and CAMERA make it larger (default 240 and 96x72), RECORDING takes one that is there, FLAGS
# go to reconstruct, and mishaps come after so many scans of a shard as AFTER says (4).
set -euo pipefail

farm=$1 program=$2 folder=$3
windows=${WINDOWS:-240} camera=${CAMERA:-96x72}
repository=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
processes=()

say() { printf '%s\n' "farm_test.sh: $*"; }
skip() { say "skipped: $*"; exit 77; }
fail() { say "$*" >&2; exit 1; }
seconds_since() { echo "$(($(date +%s) - $1)) s"; }

finish() {
  local process
  for process in "${processes[@]}"; do kill -9 "$process" 2>/dev/null || true; done
}
trap finish EXIT

declare -A programs=([slurm]="slurmctld slurmd munged sbatch" [parallel]=parallel
                     [ssh]="parallel ssh ssh-keygen sshd")
PATH=$PATH:/usr/sbin
for needed in ${programs[$farm]}; do
  command -v "$needed" >/dev/null || skip "no $needed"
done
[ "$farm" = parallel ] || [ "$(id -u)" = 0 ] || skip "slurmd and sshd want root"

rm -rf "$folder"
mkdir -p "$folder"/{one,many,first}
cd "$folder"
recording=${RECORDING:-$folder/a.slip}
if [ -z "${RECORDING:-}" ]; then
  "$program" record --source virtual --camera "$camera" --strategy pmp --steps 3 --rate 0 \
    --frames $((3 * windows)) -o "$recording" >/dev/null
fi
printf '%s\t:\n' "$recording" >archive.txt

# What the farm runs: the program, but for mishaps of the first time.
cat >node <<TEXT
#!/usr/bin/env bash
shard=\${5:-}
shard=\${shard%/*}
if mkdir first/\$shard 2>/dev/null && [[ \$shard = [25] ]]; then
  "$program" "\$@" &
  until [ "\$(wc -l <plan/shard-00000\$shard.jsonl)" -gt ${AFTER:-4} ]; do :; done 2>/dev/null
  kill -9 \$!
  [ \$shard = 5 ] && exit 1
  if [ -n "\${SLURMD_NODENAME:-}" ]; then kill -9 \$(cat \$SLURMD_NODENAME.pid) \$(ps -o ppid= \$PPID) \$PPID; fi
  if [ -n "\${SSH_CONNECTION:-}" ]; then
    sshd=\$(cat \${SSH_CONNECTION##* }.pid)
    touch node_down
    kill -9 \$sshd \$(ps -o pid= --ppid \$sshd)
  fi
  kill -9 \$\$
fi
exec "$program" "\$@"
TEXT
chmod +x node

start_slurm() {
  local node
  head -c 128 /dev/urandom >munge.key
  chmod 400 munge.key
  chmod 755 .
  cat >slurm.conf <<TEXT
ClusterName=test
SlurmctldHost=$(hostname -s)(127.0.0.1)
SlurmctldPort=26817
AuthType=auth/munge
AuthInfo=socket=$folder/munge.socket,cred_expire=10
SlurmUser=root
SlurmdUser=root
StateSaveLocation=$folder/state
SlurmctldPidFile=$folder/slurmctld.pid
SlurmctldLogFile=$folder/slurmctld.log
SlurmdPidFile=$folder/%n.pid
SlurmdLogFile=$folder/%n.log
SlurmdSpoolDir=$folder/spool-%n
SlurmdTimeout=6
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
ReturnToService=2
SwitchType=switch/none
MpiDefault=none
MailProg=/bin/true
SchedulerParameters=sched_interval=1,batch_sched_delay=0
NodeName=node1 NodeAddr=127.0.0.1 Port=26821 CPUs=1
NodeName=node2 NodeAddr=127.0.0.1 Port=26822 CPUs=1
NodeName=node3 NodeAddr=127.0.0.1 Port=26823 CPUs=1
PartitionName=all Nodes=node[1-3] Default=YES MaxTime=INFINITE State=UP
TEXT
  export SLURM_CONF=$folder/slurm.conf
  munged --force --foreground --socket="$folder/munge.socket" --key-file="$folder/munge.key" \
    --pid-file="$folder/munged.pid" --log-file="$folder/munged.log" --seed-file="$folder/seed" \
    >/dev/null 2>&1 &
  processes+=($!)
  slurmctld -D -c >/dev/null 2>&1 &
  processes+=($!)
  for node in node1 node2 node3; do
    slurmd -D -N $node >/dev/null 2>&1 &
    processes+=($!)
  done
  timeout 60 bash -c 'until [ "$(sinfo -h -t idle -o %D 2>/dev/null)" = 3 ]; do sleep 0.2; done' ||
    { tail -n 5 slurmctld.log node1.log; skip "Slurm does not start here"; }
}

# Two hosts that parallel reaches by ssh alone: node1 and node2.
start_hosts() {
  local node port
  mkdir -p /run/sshd
  ssh-keygen -q -t ed25519 -N '' -f key
  for node in 1 2; do
    port=2682$((3 + node))
    "$(command -v sshd)" -D -f /dev/null -o Port=$port -o ListenAddress=127.0.0.1 -o UsePAM=no \
      -o HostKey="$folder/key" -o AuthorizedKeysFile="$folder/key.pub" -o StrictModes=no \
      -o PermitRootLogin=yes -o PidFile="$folder/$port.pid" 2>sshd$node.log &
    processes+=($!)
    printf '%s\n' "Host node$node" "HostName 127.0.0.1" "Port $port" "IdentityFile $folder/key" \
      "UserKnownHostsFile /dev/null" "StrictHostKeyChecking no" "LogLevel ERROR" >>ssh_config
  done
  timeout 10 bash -c 'until ssh -F ssh_config node1 true && ssh -F ssh_config node2 true; do
    sleep 0.2; done' 2>ssh.log || { tail -n 5 ssh.log sshd1.log; skip "sshd does not start here"; }
}

begun=$(date +%s)
"$program" reconstruct archive.txt -o 'one/{name}-{window}.ply' --manifest one.jsonl ${FLAGS:-} >one.log
say "one run: $(seconds_since "$begun")"
"$program" batch plan archive.txt --tasks 8 --plan plan -o 'many/{name}-{window}.ply' ${FLAGS:-}

begun=$(date +%s)
if [ "$farm" = slurm ]; then
  start_slurm
  begun=$(date +%s)
  SLIPSTREAM=$folder/node "$repository/packaging/slurm/batch.sh" plan
  timeout 3600 bash -c 'until [ -z "$(squeue -h)" ]; do sleep 0.5; done' || fail "$(squeue)"
  grep -h 'whole' plan/merge.log
  grep -q 'node.* not responding, setting DOWN' slurmctld.log || fail "no node went down"
elif [ "$farm" = ssh ]; then
  start_hosts
  begun=$(date +%s)
  parallel --ssh "ssh -F $folder/ssh_config" --sshlogin 1/node1,1/node2 --workdir "$folder" \
    --joblog joblog --retries 3 ./node batch run plan --shard {}/8 ::: 1 2 3 4 5 6 7 8 >parallel.log
  "$program" batch merge plan
  [ -e node_down ] || fail "no node went down"
else
  # A host named : is this one, without ssh.
  farm_of_parallel=(parallel --joblog joblog --sshlogin 2/: --workdir "$folder"
                    ./node batch run plan --shard {}/8 ::: 1 2 3 4 5 6 7 8)
  "${farm_of_parallel[@]}" >parallel.log && fail "no shard failed"
  "${farm_of_parallel[0]}" --resume-failed "${farm_of_parallel[@]:1}" >>parallel.log
  "$program" batch merge plan
fi
say "8 shards under $farm: $(seconds_since "$begun")"

[ -d first/2 ] && [ -d first/5 ] || fail "no mishap came"
# SIGKILL may leave what was half written under its temporary name.
diff -r --exclude='*.part' one many || fail "the clouds are not those of one run"
count=$(ls one | wc -l)
[ "$(wc -l <plan/manifest.jsonl)" = "$count" ] || fail "the manifest is not complete"
[ "$(cat plan/shard-*.jsonl | wc -l)" = "$count" ] || fail "a scan was done twice"
"$program" batch run plan --shard 5 | grep -q 'were done before' || fail "a shard was done again"
say "all $count scans are there, once, as one run makes them"
