asm complex_name
signature:
  controlled i: Integer //~ L055
definitions:
  main rule r_Main = i1 := 1 //~ L055
