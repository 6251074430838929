#!/usr/bin/env bash
# A Slurm of one node on this machine, from Debian packages, without systemd and cgroups:
#
#   tests/slurm/one_node.sh up      installs what dpkg lacks, starts munged, slurmctld, slurmd
#   tests/slurm/one_node.sh down    ends them, and removes their slurm.conf: each start of Snakemake
#                                   would wait ten seconds for a controller that is down
#
# For tests alone: it runs as root, keeps no accounts, and listens on this machine only.
set -euo pipefail

packages=(munge slurmctld slurmd slurm-client)
home=${SLURM_TEST_HOME:-/var/lib/pidpanel-slurm}
export SLURM_CONF=/etc/slurm/slurm.conf

say() { printf 'one_node: %s\n' "$*" >&2; }
die() { say "$*"; exit 2; }

install_packages() {
  local installed missing=() package
  installed=$(dpkg-query -W -f='${Package} ${db:Status-Status}\n' "${packages[@]}" 2>/dev/null || true)
  for package in "${packages[@]}"; do
    grep -qxF "$package installed" <<<"$installed" || missing+=("$package")
  done
  ((${#missing[@]})) || return 0
  say "installing ${missing[*]}"
  export DEBIAN_FRONTEND=noninteractive
  { apt-get -q update && apt-get -q install -y --no-install-recommends "${missing[@]}"; } >&2 ||
    die "apt-get failed (see above); wanted: ${missing[*]}"
}

is_ours() { grep -qs '^ClusterName=pidpanel-test$' "$SLURM_CONF"; }

configure() {
  local name cpus memory
  [ ! -e "$SLURM_CONF" ] || is_ours || die "$SLURM_CONF is of another cluster; not touched"
  name=$(hostname -s)
  cpus=$(nproc --all) # nproc alone follows OMP_NUM_THREADS
  memory=$(awk '/^MemTotal/ {print int($2 / 1024 * 0.9)}' /proc/meminfo)
  mkdir -p "$home"/{state,spool} /etc/slurm
  cat >"$SLURM_CONF" <<CONF
ClusterName=pidpanel-test
SlurmctldHost=$name(127.0.0.1)
SlurmUser=root
AuthType=auth/munge
StateSaveLocation=$home/state
SlurmdSpoolDir=$home/spool
SlurmctldPidFile=$home/slurmctld.pid
SlurmdPidFile=$home/slurmd.pid
SlurmctldLogFile=$home/slurmctld.log
SlurmdLogFile=$home/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/linux
JobAcctGatherFrequency=1
AccountingStorageType=accounting_storage/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SlurmdParameters=config_overrides
MpiDefault=none
ReturnToService=2
MinJobAge=3600
KillWait=5
NodeName=$name NodeAddr=127.0.0.1 CPUs=$cpus RealMemory=$memory State=UNKNOWN
PartitionName=test Nodes=$name Default=YES MaxTime=60 State=UP
CONF
  # Slurm 23.11 and later look for cgroups unless told not to; earlier ones do not know the word
  if dpkg --compare-versions "$(dpkg-query -W -f='${Version}' slurmctld)" ge 23.11; then
    echo 'CgroupPlugin=disabled' >/etc/slurm/cgroup.conf
  fi
}

is_up() { timeout 5 sinfo -h -o %T 2>/dev/null | grep -qE '^(idle|mixed|allocated|completing)'; }

runs() { [ -e "$1" ] && kill -0 "$(<"$1")" 2>/dev/null; }

start_munge() {
  munge -n </dev/null 2>/dev/null | unmunge >/dev/null 2>&1 && return 0
  [ -s /etc/munge/munge.key ] || dd if=/dev/urandom of=/etc/munge/munge.key bs=1024 count=1 status=none
  mkdir -p /run/munge /var/log/munge /var/lib/munge
  chown -R munge: /etc/munge /run/munge /var/log/munge /var/lib/munge
  chmod 400 /etc/munge/munge.key
  chmod 711 /run/munge
  setpriv --reuid munge --regid munge --clear-groups munged --force
}

up() {
  ((EUID == 0)) || die "needs root"
  is_up && return 0
  install_packages
  configure
  start_munge
  runs "$home/slurmctld.pid" || slurmctld
  runs "$home/slurmd.pid" || slurmd
  for _ in $(seq 100); do
    is_up && return 0
    sleep 0.2
  done
  tail -n 5 "$home"/slurm{ctld,d}.log >&2
  die "no node is up after 20 s (see above)"
}

down() {
  local file
  for file in "$home"/slurm{d,ctld}.pid /run/munge/munged.pid; do
    runs "$file" && kill "$(<"$file")"
  done
  ! is_ours || rm "$SLURM_CONF"
}

case ${1:-} in
  up | down) "$1" ;;
  *) die "say up or down" ;;
esac
