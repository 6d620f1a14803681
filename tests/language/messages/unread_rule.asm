asm unread_rule
import StandardLibrary
signature:
  controlled x: Integer
definitions:
  rule r_set($n in Integer)
    x := $n  //~ L052
  main rule r_Main = r_set[1]
