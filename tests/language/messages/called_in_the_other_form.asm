asm called_in_the_other_form
import StandardLibrary
signature:
  controlled x: Integer
definitions:
  rule r_set($n in Integer) = x := $n
  main rule r_Main = r_set(3)  //~ A025
