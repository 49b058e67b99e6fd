#!/bin/bash
# Prints the address of the Debian mirror that this machine installs from, whatever the format of its lists.
set -euo pipefail
mirror=$(apt-get indextargets --no-release-info --format '$(REPO_URI) $(RELEASE) $(COMPONENT)' 'Identifier: Packages' 2>/dev/null |
    awk '$2 !~ /[-\/]/ && $3 == "main" && $1 ~ /\/debian\/?$/ {print $1; exit}') || true
echo "${mirror:-http://deb.debian.org/debian/}"
