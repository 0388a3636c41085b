#!/bin/sh
# Runs as root in a Debian that systemd has booted, with the package and the configurations of its service in /check. Says what holds, a line each; ends with 1 at
# the first that does not.
set -eu
API=http://127.0.0.1:8081/api/v1

# holds WHAT COMMAND: within a minute and a half.
holds() {
    what=$1
    left=90
    until sh -c "$2" >/dev/null 2>&1; do
        left=$((left - 1))
        if [ "$left" -le 0 ]; then
            echo "NOT: $what"
            systemctl status skein --no-pager || true
            journalctl --no-pager -n 20 -u skein -u ground || true
            skein upgrade || true
            curl -s "$API/fleet" | head -c 2000 || true
            exit 1
        fi
        sleep 1
    done
    echo "$what"
}
property() { systemctl show skein -p "$1" --value; }
is() { echo "curl -s $API/fleet | jq -e '.vehicles[0] | $1'"; }
asked() {
    body="{\"targets\":{\"vehicles\":[$(curl -s "$API/fleet" | jq '.vehicles[0].id')]},\"command\":$1}"
    echo "curl -s -X POST -H 'content-type: application/json' -d '$body' $API/commands | jq -e '[.. | .refusal? // empty] == []'"
}

dpkg -i /check/skein.deb >/dev/null
install -m 0644 /check/vehicle.toml /etc/skein/skein.toml
install -m 0600 -o skein -g skein /check/swarm.key /etc/skein/swarm.key
install -m 0600 /check/swarm.key /root/swarm.key
mkdir -p /root/ground
systemd-run -q --unit=ground --setenv=STATE_DIRECTORY=/root/ground -p WorkingDirectory=/root/ground /usr/bin/skein run --config /check/ground.toml
systemd-run -q --unit=simulation /usr/bin/skein sim --vehicles 1
# Type=notify: this returns when the node says that it is up.
systemctl start skein
[ "$(property ActiveState)" = active ]
echo "up, as the node itself has said"

holds "a vehicle is found" "$(is '.ready_to_arm')"
holds "a plugin in a process of its own runs in the sandbox" "$(is '.payloads[0] | .plugin.status == "running" and .plugin.process_id')"
holds "it takes off" "$(asked '{"command":"take_off","height_m":5}')"
holds "it flies" "$(is '.landed == "in_air" and .flight_state == "holding"')"

kill -STOP "$(property MainPID)"
holds "a node that stands still is ended by the watchdog, and begins again" '[ "$(systemctl show skein -p NRestarts --value)" = 1 ] && [ "$(systemctl is-active skein)" = active ]'
holds "the vehicle is in the air, and held" "$(is '.landed == "in_air" and .flight_state == "holding"')"
kill -KILL "$(property MainPID)"
holds "a node that is killed begins again" '[ "$(systemctl show skein -p NRestarts --value)" = 2 ] && [ "$(systemctl is-active skein)" = active ]'
holds "the vehicle is in the air, and held" "$(is '.landed == "in_air" and .flight_state == "holding"')"
holds "it is landed" "$(asked '{"command":"land"}')"
holds "it is down" "$(is '.armed | not')"

export SKEIN_OPERATOR=secret
dpkg-deb -x /check/skein.deb /root/new
skein upgrade pack /root/new /root/new.tar.gz --version 99.0.0 >/dev/null
rm /root/new/usr/lib/skein/plugins/libgeneric_uav_plugin.so
skein upgrade pack /root/new /root/broken.tar.gz --version 99.1.0 >/dev/null
holds "the ground station hears of it" "curl -s http://127.0.0.1:8080/api/v1/fleet | jq -e '.vehicles[0].armed == false'"
runs_new='readlink "/proc/$(systemctl show skein -p MainPID --value)/exe" | grep -q /versions/99.0.0'
skein upgrade /root/new.tar.gz
holds "the new version runs" "$runs_new"
skein upgrade /root/broken.tar.gz && exit 1
holds "a version without its plugin goes back" "$runs_new"

systemctl stop skein
[ "$(property Result)" = success ]
echo "stopped"
echo 'nonsense = 1' >> /etc/skein/skein.toml
systemctl start skein || true
sleep 3
[ "$(property ActiveState)" = failed ] && [ "$(property ExecMainStatus)" = 64 ] && [ "$(property NRestarts)" = 0 ]
echo "a wrong configuration is refused once, and not tried again"
