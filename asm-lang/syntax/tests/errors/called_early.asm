asm called_early
signature:
  controlled a: Integer
definitions:
  // calls what comes later
  rule r_first = r_second[] //~ L076
  // is moved with its comment
  rule r_second = a := 1
  main rule r_Main = r_first[]
