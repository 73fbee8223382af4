# An OpenSSH server on host b of two_hosts.sh, for this test alone: its own port, host key and authorized key. Source it
# after two_hosts.sh; $reach are the words that start a program on b. Ends the calling test as skipped (77) where there
# is none.
for tool in sshd ssh ssh-keygen; do
    command -v "$tool" >/dev/null || skip "$tool is not installed (openssh-server, openssh-client)"
done
ssh_folder=$work-ssh
trap 'clean_up; rm -rf "$ssh_folder"' EXIT
mkdir -m 700 "$ssh_folder"
ssh-keygen -q -t ed25519 -N "" -f "$ssh_folder/host_key"
ssh-keygen -q -t ed25519 -N "" -f "$ssh_folder/user_key"
cp "$ssh_folder/user_key.pub" "$ssh_folder/authorized_keys"
printf '[host-b]:2222 %s\n' "$(cat "$ssh_folder/host_key.pub")" >"$ssh_folder/known_hosts"
cat >"$ssh_folder/sshd_config" <<EOT
Port 2222
ListenAddress 10.71.0.2
HostKey $ssh_folder/host_key
AuthorizedKeysFile $ssh_folder/authorized_keys
PidFile none
PasswordAuthentication no
PermitRootLogin prohibit-password
StrictModes no
UsePAM no
EOT
cat >"$ssh_folder/config" <<EOT
Port 2222
IdentityFile $ssh_folder/user_key
IdentitiesOnly yes
UserKnownHostsFile $ssh_folder/known_hosts
GlobalKnownHostsFile none
HostKeyAlgorithms ssh-ed25519
EOT
on_b "$(command -v sshd)" -f "$ssh_folder/sshd_config" 2>"$work/why" || skip "no sshd: $(cat "$work/why")"
for _ in $(seq 100); do # it listens a moment after it has gone into the background
    on_b ss -ltnH | grep -q ':2222 ' && break
    sleep 0.1
done
on_a ssh -F "$ssh_folder/config" -o BatchMode=yes host-b true 2>"$work/why" || skip "no login: $(cat "$work/why")"
reach="ssh, -F, $ssh_folder/config"
reach_tool=ssh
