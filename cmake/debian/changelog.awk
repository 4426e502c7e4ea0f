# awk -v version=0.2.0 -v date="Thu, 01 Jan 2026 00:00:00 +0000" -v contact="NAME <ADDRESS>" -f changelog.awk CHANGELOG.md
# Debian's form of what CHANGELOG.md says of a version, and of what is not released above it: lines of at most 80 columns.
function put(indent, text,    words, count, i, line) {
  count = split(text, words, " ")
  line = indent
  sub(/\*/, " ", indent)
  for (i = 1; i <= count; i++) {
    if (length(line) + length(words[i]) + 1 > 79 && line ~ /[^ *]/) {
      print line
      line = indent
    }
    line = line (line ~ / $/ ? "" : " ") words[i]
  }
  if (line ~ /[^ *]/) print line
}
function flush() {
  if (item != "") put("  * ", item)
  item = ""
}
BEGIN { print "stonestack (" version ") unstable; urgency=medium\n" }
/^## / {
  flush()
  if (ended) exit
  if ($2 == version) ended = 1
  inside = 1
  next
}
!inside { next }
/^### / { flush(); if (areas++) print ""; print "  [ " substr($0, 5) " ]"; next }
/^- / { flush(); item = substr($0, 3); next }
NF { item = item " " $0 }
END {
  flush()
  print "\n -- " contact "  " date
}
