# Comments are plain text: what looks like HTML or a command of Doxygen in them is none. Code in them stays code.
/^ *\/\/\/ {0,3}[^ ]/{
  s/</\&lt;/g
  s/\\([xn])/\\\\\1/g
  s/(^|[ (,])\.\.([ ,;)]|$)/\1\&hellip;\2/g
}
/^ *\/\/\/ {4}/s/<(class|cmath)/< \1/g
s_///<(.*)<_///<\1\&lt;_
