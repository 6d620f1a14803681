asm missing_in_binder
signature:
definitions:
  main rule r_Main =
    choose $x s do a := $x //~ L052
