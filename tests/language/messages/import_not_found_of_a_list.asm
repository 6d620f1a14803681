// the import can only bring the names that it lists
asm import_not_found_of_a_list
import StandardLibrary
import arms(grip)                            //~ A010
signature:
  controlled n: Integer
definitions:
  main rule r_Main = n := grip + grap        //~ A001
