asm cannot_extend
import StandardLibrary
signature:
  domain Small subsetof Integer
definitions:
  domain Small = {1 : 3}
  main rule r_Main = extend Small with $s do skip  //~ A026
