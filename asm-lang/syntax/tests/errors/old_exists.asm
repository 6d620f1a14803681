asm old_exists
signature:
definitions:
  main rule r_Main = if (exist $x in s with $x = 1) then skip endif //~ L070
