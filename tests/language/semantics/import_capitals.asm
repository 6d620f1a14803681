// where files are found whatever their capitals, people write library names with others
asm import_capitals
import ../standardLibrary
signature:
  controlled x: Integer
definitions:
  main rule r_Main = x := 1 + 1
//= step 1: x := 2
