asm square_arguments
signature:
definitions:
  main rule r_Main = a[1] := 2 //~ L041
