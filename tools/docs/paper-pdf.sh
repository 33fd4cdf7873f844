#!/usr/bin/env bash
# Typesets paper/paper.md, an article in the form of the Journal of Open Source Software, as build/paper/paper.pdf.
set -u
. "$(dirname "$0")/../environment.sh"

folder=$top/build/paper
mkdir -p "$folder" && cd paper || exit 1
authors=$(sed -n '/^authors:/,/^affiliations:/s/^ *- name: //p' paper.md | sed '$!s/$/, /' | tr -d '\n')
quietly paper-pdf pandoc paper.md --citeproc --bibliography=paper.bib --pdf-engine=pdflatex --variable=geometry:margin=2.5cm \
   --variable=author="$authors" --variable=colorlinks --output="$folder/paper.pdf" || exit 1
say "Paper: build/paper/paper.pdf, $(pandoc paper.md --to=plain | wc -w) words"
