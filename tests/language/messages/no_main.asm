asm no_main  //~ W005 R015
signature:
  controlled x: Integer
definitions:
  rule r_go = x := 1
