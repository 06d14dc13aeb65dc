#!/bin/sh
# Makes delta_cad/report/vendor/three.js again from its package, which needs npm; users of the project do not.
set -eu

three=0.183.2
esbuild=0.28.2
here=$(cd "$(dirname "$0")/.." && pwd)/delta_cad/report/vendor
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

cp "$here/entry.js" "$work/entry.js"
cd "$work"
npm init --yes >/dev/null
npm install --silent --no-audit --no-fund "three@$three" "esbuild@$esbuild"
npx esbuild entry.js --bundle --minify --format=iife --global-name=THREE --target=es2020 --charset=ascii \
    --legal-comments=none --log-level=warning --outfile=three.js
cp three.js "$here/three.js"
cp node_modules/three/LICENSE "$here/three.LICENSE"
integrity=$(node -p 'require("./package-lock.json").packages["node_modules/three"].integrity')
cat >"$here/three.json" <<EOF
{
 "package": "three",
 "version": "$three",
 "source": "npm package three@$three, bundled from entry.js",
 "integrity": "$integrity",
 "bundler": "esbuild $esbuild",
 "license": "MIT",
 "sha256": "$(sha256sum three.js | cut -d ' ' -f 1)"
}
EOF
cat "$here/three.json"
