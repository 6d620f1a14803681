asm complex_name_after_a_function
signature:
  domain Place subsetof Integer
  controlled n: Integer
  controlled i: Seq(Integer) //~ L055
definitions:
  main rule r_Main = skip
