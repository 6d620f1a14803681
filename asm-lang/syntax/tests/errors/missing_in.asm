asm missing_in
signature:
definitions:
  main rule r_Main =
    let ($x = 1) a := $x endlet //~ L052
