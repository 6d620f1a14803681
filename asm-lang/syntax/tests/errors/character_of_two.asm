asm character_of_two
signature:
definitions:
  main rule r_Main = a := 'ab' //~ L005
