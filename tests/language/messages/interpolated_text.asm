asm interpolated_text
import StandardLibrary
signature:
  controlled n: Integer
  controlled robot: String
  controlled said: String
definitions:
  main rule r_Main = let ($x = 1) in seq
    said := "n = ${n}, robot ${robot}"   //~ W032
    said := "at ${ $x + 1 }"             //~ W032
    said := "${robot}"                   //~ W032
    said := "é ${unknown} ${n"
    said := "${size} costs $n {n} ${}"
    said := "n = " + toString(n)
  endseq endlet
