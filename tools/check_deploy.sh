#!/usr/bin/env bash
# Holds what stands in deploy/ to the programs and schemas that will read it: HAProxy, Prometheus, Docker Compose,
# Kubernetes. What it does is tested by tests/deploy, with the servers.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

for file in deploy/haproxy*.cfg; do haproxy -c -q -f "$file"; done
promtool check config deploy/prometheus/prometheus.yml >/dev/null
FORELAND_SCENE=/scene.fls docker-compose -f deploy/compose.yaml config -q
if FORELAND_SCENE=/scene.fls docker-compose -f <(sed s/read_only/readonly/ deploy/compose.yaml) config -q 2>/dev/null; then
  echo "check_deploy: docker-compose takes an option that there is not" >&2
  exit 1
fi
cd tests/deploy/manifests
[[ node_modules/.package-lock.json -nt package-lock.json ]] || npm ci --no-audit --no-fund --loglevel=error
npm test --silent
