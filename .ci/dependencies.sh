# The crates of the registry, compiled once for all runs of this user. What is compiled of this workspace is not kept: cargo takes its age for
# its content, so that an older checkout could pass on the program of another one.
#
# Must never do: fail a run. Whatever is odd about the cache, the run builds from nothing in its own folder, or in an empty one.

# What is kept is forgotten when it is larger, in KiB: dependencies of several states of Cargo.lock add up.
most_kib=$((12 * 1024 * 1024))

# Sets CARGO_TARGET_DIR to a folder of the cache, for one run at a time; without a word if there is a folder already, or no cache.
keep_dependencies() {
    local home=${XDG_CACHE_HOME:-${HOME:-/nonexistent}/.cache}/skein-ci
    if [ -n "${CARGO_TARGET_DIR:-}" ] || ! mkdir -p "$home" 2>/dev/null || ! { exec 9>"$home/lock"; } 2>/dev/null; then
        return 0
    fi
    if ! flock -n 9; then
        echo "another run has the cache of dependencies: this one builds from nothing"
        return 0
    fi
    # What a crate compiles to rests on these; of one such world at a time.
    local world
    world=$({ rustc -vV; echo "${CARGO_HOME:-} ${RUSTFLAGS:-}"; } | sha256sum | cut -c1-16)
    kept=$home/$world
    find "$home" -mindepth 1 -maxdepth 1 -type d ! -path "$kept" -exec rm -rf {} +
    # Half written: the machine went down under it, or it was killed.
    if [ -e "$kept/in-use" ] || [ "$(du -sk "$kept" 2>/dev/null | cut -f1 || echo 0)" -gt "$most_kib" ]; then
        rm -rf "$kept"
    fi
    mkdir -p "$kept/target"
    : >"$kept/in-use"
    export CARGO_TARGET_DIR=$kept/target
    trap give_back_dependencies EXIT
    forget_own
}

# Ends the run's hold on the cache.
give_back_dependencies() {
    forget_own
    rm -f "$kept/in-use"
}

# Leaves only what cargo made of other people's crates.
forget_own() {
    if ! cargo clean --quiet --workspace; then
        rm -rf "$kept/target"
        mkdir -p "$kept/target"
        return 0
    fi
    find "$kept/target" -mindepth 1 -maxdepth 1 ! -name debug ! -name CACHEDIR.TAG ! -name '.rustc_info.json' -exec rm -rf {} +
    find "$kept/target/debug" -mindepth 1 -maxdepth 1 ! -name deps ! -name build ! -name .fingerprint ! -name .cargo-lock -exec rm -rf {} + 2>/dev/null || true
}
