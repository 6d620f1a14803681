asm misnamed_location
signature:
definitions:
  main rule r_Main = Speed := 2 //~ L056
