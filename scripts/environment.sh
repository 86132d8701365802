# Sourced by the scripts: makes .venv with the project installed, once for each pyproject.toml and
# each version of what is compiled.
# Sets `root` and puts the environment's programs first on the path.

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

complain() {
  printf 'error: %s\n' "$1" >&2
  exit 1
}

find_python() {
  local candidate
  for candidate in "${PYTHON:-}" python3 python python3.14 python3.13 python3.12 python3.11 python3.10; do
    if [ -n "$candidate" ] && command -v "$candidate" >/dev/null 2>&1 \
      && "$candidate" -c 'import sys; sys.exit(sys.version_info < (3, 10))' 2>/dev/null; then
      command -v "$candidate"
      return
    fi
  done
  complain "gaitopt needs Python 3.10 or newer, and none was found; install one, or name it: PYTHON=/path/to/python $0"
}

# use_environment EXTRAS: EXTRAS is empty, or as "[test]"; what an earlier call installed is kept.
use_environment() {
  local extras=$1 venv="$root/.venv" python stamp wanted
  if [ ! -x "$venv/bin/python" ]; then
    python=$(find_python)
    printf 'making %s with %s\n' "$venv" "$("$python" --version)" >&2
    "$python" -m venv "$venv" || {
      rm -rf "$venv"
      complain "'$python -m venv' failed; on Debian and Ubuntu: apt-get install python3-venv"
    }
    # That of Python 3.10, pip 23.0, went through old versions of the extras for 28 minutes, without end.
    "$venv/bin/python" -m pip install --quiet --disable-pip-version-check --upgrade pip \
      || complain "pip cannot be brought up to date; see the messages above, then run $0 again"
  fi
  stamp="$venv/.installed$extras"
  wanted="$(cat "$root/pyproject.toml" "$root/setup.py" "$root"/gaitopt/*/*.[ch]pp | cksum) $root"
  if [ "$(cat "$stamp" 2>/dev/null || true)" != "$wanted" ]; then
    printf 'installing gaitopt%s (once)\n' "$extras" >&2
    "$venv/bin/python" -m pip install --quiet --disable-pip-version-check --editable "$root$extras" \
      || complain "the installation failed; see the messages above, then run $0 again"
    printf '%s\n' "$wanted" > "$stamp"
  fi
  PATH="$venv/bin:$PATH"
}
