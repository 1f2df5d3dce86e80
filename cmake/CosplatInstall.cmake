# placeholder until the libraries exist
