asm element_name
signature:
definitions:
  main rule r_Main = age(person!1) := 1 //~ L011
